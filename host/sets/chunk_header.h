// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>

#include "host/sets/contact_set.h"
#include "host/support/checksum.h"

namespace tactel::host {

/// Header of the rows of a chunk. The byte order is that of the machine; the folder cannot be moved to another
/// kind.
struct ChunkHeader {
  static constexpr std::uint64_t right_magic = 0x396c6f6f70736c74;  // "tlspool9"

  std::uint64_t magic = 0, plan_sum = 0, chunk = 0, rows = 0, contacts = 0, inputs = 0, bytes = 0;
  SetCounts counts{};
  std::uint64_t payload_sum = 0;  ///< checksum of the rows that follow
  std::uint64_t header_sum = 0;   ///< checksum of the preceding members

  std::uint64_t sum() const {
    return checksum({reinterpret_cast<const char*>(this), offsetof(ChunkHeader, header_sum)});
  }
  bool whole() const { return magic == right_magic && header_sum == sum(); }
};

}  // namespace tactel::host
