// SPDX-License-Identifier: Apache-2.0
#include "host/support/terminal.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace tactel::host {
namespace {

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

void print(std::string_view label, Colour colour, std::string_view text) {
  const std::string line =
      (takes_colour(STDERR_FILENO) ? painted(label, colour) : std::string(label)) + " " + std::string(text) + "\n";
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace

bool is_terminal(int descriptor) {
  const std::string_view kind = environment("TERM");
  return isatty(descriptor) == 1 && !kind.empty() && kind != "dumb";
}

bool takes_colour(int descriptor) { return is_terminal(descriptor) && environment("NO_COLOR").empty(); }

std::string painted(std::string_view text, Colour colour) {
  return "\x1b[1;" + std::to_string(static_cast<int>(colour)) + "m" + std::string(text) + "\x1b[0m";
}

void print_error(std::string_view text) { print("error:", Colour::red, text); }
void print_warning(std::string_view text) { print("warning:", Colour::yellow, text); }

}  // namespace tactel::host
