// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "hw/generic_format.h"

namespace tactel::hw {

/// A generic frame with everything a profile can ask for: counter, clock, checksum, trailer.
inline GenericLayout counted_layout() {
  GenericLayout layout;
  layout.sync = {0xA5, 0x5A};
  layout.header = 8;
  layout.counter = {2, 2};
  layout.clock = {4, 4};
  layout.channels = 4;
  layout.checksum = Checksum::crc16;
  layout.trailer = {0x0D};
  layout.confirmations = 2;
  return layout;
}

}  // namespace tactel::hw
