// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "host/support/errors.h"
#include "tests/scratch.h"

namespace tactel::fuzz {

using Bytes = std::span<const std::uint8_t>;
inline Bytes as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// A target: what the program does with an input where FUZZ_TARGET=name.
struct Target {
  Target(std::string_view name, void (*run)(Bytes));
};

/// A folder of this process under the temporary directory ($TMPDIR), removed at its end.
const std::filesystem::path& folder();
/// Writes folder()/name with exactly these bytes, and returns its path.
std::filesystem::path write_file(const std::string& name, Bytes bytes);

/// Ends the program where a property does not hold: a finding.
void check(bool met, const char* property);
/// Checks that the text of an error can be shown on a terminal as one line: neither empty nor with control characters.
void check_message(const std::exception& error);

/// Calls `read`. True where it returned, false where it threw a Refusal, the documented answer to a file that cannot be
/// used. Any other exception passes through and ends the program.
template <class Refusal = ConfigError, class Read>
bool accepts(const Read& read) {
  try {
    read();
    return true;
  } catch (const Refusal& error) {
    check_message(error);
    return false;
  }
}

/// Calls `read` with an input as it is and, where that differs, with its checksums made right by `repair`.
template <class Read, class Repair>
void read_twice(Bytes input, const Read& read, const Repair& repair) {
  const std::string bytes(input.begin(), input.end());
  read(bytes);
  if (const std::string repaired = repair(bytes); repaired != bytes) read(repaired);
}

/// Takes numbers from the front of an input; zeros once it is used up.
class Choices {
 public:
  explicit Choices(Bytes bytes) : rest_(bytes) {}
  bool empty() const { return rest_.empty(); }
  std::uint8_t byte();
  /// A number below `count`.
  std::size_t below(std::size_t count) { return byte() % count; }
  std::uint32_t word();

 private:
  Bytes rest_;
};

}  // namespace tactel::fuzz
