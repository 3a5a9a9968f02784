// SPDX-License-Identifier: Apache-2.0
#include "host/support/terminal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>

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

void open_if_closed(int fd, int wrong_direction) {
  if (::fcntl(fd, F_GETFD) >= 0 || errno != EBADF) return;
  ::open("/dev/null", wrong_direction);  // takes the lowest number that is free: those below are open by now
}

ssize_t write_and_forget(void*, const char* text, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t count = ::write(STDERR_FILENO, text + done, size - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  return static_cast<ssize_t>(size);
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

void prepare_standard_streams() {
  std::signal(SIGXFSZ, SIG_IGN);
  open_if_closed(STDIN_FILENO, O_WRONLY);
  open_if_closed(STDOUT_FILENO, O_RDONLY);
  open_if_closed(STDERR_FILENO, O_RDONLY);
  std::FILE* forgiving = ::fopencookie(nullptr, "w", {nullptr, write_and_forget, nullptr, nullptr});
  if (forgiving == nullptr) return;
  std::setvbuf(forgiving, nullptr, _IONBF, 0);
  stderr = forgiving;
}

std::optional<std::string> lost_output() {
  if (std::fflush(stdout) != 0) return std::strerror(errno);
  std::cout.flush();
  if (std::ferror(stdout) != 0) return "a write failed";
  const int copy = ::dup(STDOUT_FILENO);  // closing a copy reports what a network file system has put off
  if (copy >= 0 && ::close(copy) != 0) return std::strerror(errno);
  return std::nullopt;
}

}  // namespace tactel::host
