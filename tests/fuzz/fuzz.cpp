// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>

namespace tactel::fuzz {
namespace {

namespace fs = std::filesystem;

using Run = void (*)(Bytes);

std::map<std::string_view, Run>& targets() {
  static std::map<std::string_view, Run> targets;
  return targets;
}

Run chosen = nullptr;

}  // namespace

Target::Target(std::string_view name, void (*run)(Bytes)) { targets().emplace(name, run); }

const fs::path& folder() {
  static const ScratchFolder own;
  static const fs::path path = own / "";
  return path;
}

fs::path write_file(const std::string& name, Bytes bytes) {
  const fs::path path = folder() / name;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  check(static_cast<bool>(file), "the input can be written to the temporary directory");
  return path;
}

void check(bool met, const char* property) {
  if (met) return;
  std::fprintf(stderr, "fuzz: does not hold: %s\n", property);
  std::abort();
}

void check_message(const std::exception& error) {
  const std::string text = error.what();
  const bool one_line = std::ranges::none_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  if (!one_line) std::fprintf(stderr, "fuzz: the message: %s\n", text.c_str());
  check(!text.empty() && one_line, "an error is one line of text without control characters");
}

std::uint8_t Choices::byte() {
  if (rest_.empty()) return 0;
  const std::uint8_t first = rest_.front();
  rest_ = rest_.subspan(1);
  return first;
}

std::uint32_t Choices::word() {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(byte()) << 8 * i;
  return value;
}

}  // namespace tactel::fuzz

// What libFuzzer calls: once, and for each input.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  using namespace tactel::fuzz;
  const char* name = std::getenv("FUZZ_TARGET");
  const auto found = targets().find(name == nullptr ? "" : name);
  if (found != targets().end()) {
    chosen = found->second;
    return 0;
  }
  std::fprintf(stderr, "FUZZ_TARGET=NAME tactel_fuzz INPUT...; the names:\n");
  for (const auto& target : targets()) std::printf("%s\n", std::string(target.first).c_str());
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tactel::fuzz::chosen({data, size});
  return 0;
}
