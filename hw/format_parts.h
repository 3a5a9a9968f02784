// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <string>

#include "fem/numbers/value_error.h"
#include "hw/wire_format.h"

namespace tactel::hw {

/// Returns `width` bytes (1 to 8) from `at` as an unsigned number, least or most significant byte first. The
/// caller checks the length.
inline std::uint64_t unsigned_at(Bytes bytes, std::size_t at, std::size_t width, bool big_endian = false) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < width; ++i) value = value << 8 | bytes[at + (big_endian ? i : width - 1 - i)];
  return value;
}

inline double float_at(Bytes bytes, std::size_t at, bool big_endian = false) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(unsigned_at(bytes, at, 4, big_endian)));
}

/// Returns `whole` where `bytes` begin with `mark`, `incomplete` where they end within it, else `nothing`.
inline Verdict::Kind begins_with(Bytes bytes, Bytes mark) {
  for (std::size_t i = 0; i < mark.size(); ++i) {
    if (i == bytes.size()) return Verdict::incomplete;
    if (bytes[i] != mark[i]) return Verdict::nothing;
  }
  return Verdict::whole;
}

/// Throws ValueError, with a key of profile files, for an invalid description of a device.
inline void require(bool met, const std::string& key, const std::string& value, const std::string& allowed) {
  if (!met) throw ValueError(key, value, allowed);
}

inline void require_within(const std::string& key, long value, long least, long most) {
  require(value >= least && value <= most, key, std::to_string(value),
          "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
}

}  // namespace tactel::hw
