// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace tactel::host {

/// Returns XXH3, 64 bit (xxhash.com): equal for equal bytes on every machine.
std::uint64_t checksum(std::string_view bytes);
/// The same as 16 hexadecimal digits.
std::string checksum_text(std::string_view bytes);

/// Returns Fletcher's checksum, 32 bit, as HDF5's filter appends it to a chunk.
std::uint32_t fletcher32(std::string_view bytes);

/// Checksum of bytes that arrive piece by piece.
class RunningChecksum {
 public:
  RunningChecksum();
  ~RunningChecksum();
  RunningChecksum(RunningChecksum&&) noexcept;
  void add(std::string_view bytes);
  /// Returns the checksum of all bytes so far, as checksum().
  std::uint64_t value() const;
  /// The same as checksum_text.
  std::string text() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactel::host
