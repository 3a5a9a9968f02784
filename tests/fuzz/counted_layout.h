// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "hw/generic_format.h"

namespace tactel::hw {

/// A generic frame with everything a profile can ask for: counter, clock, checksum, trailer.
inline GenericLayout counted_layout() {
  return {.sync = {0xA5, 0x5A},
          .header = 8,
          .counter = {2, 2},
          .clock = {4, 4},
          .channels = 4,
          .checksum = Checksum::crc16,
          .trailer = {0x0D},
          .confirmations = 2};
}

}  // namespace tactel::hw
