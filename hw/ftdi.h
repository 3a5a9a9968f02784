// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "hw/wire_format.h"

namespace tactel::hw {

/// Removes the two bytes of line status that an FTDI bridge puts before the data of each packet, even an empty
/// one.
inline Bytes without_ftdi_status(Bytes packet) { return packet.subspan(packet.size() < 2 ? packet.size() : 2); }

/// Returns the divisor of 3 MHz, in eighths, as FTDI's set-baud request takes it: whole part in 14 bits, a code
/// for the eighths above (FTDI application note AN_120). The two fastest rates have codes of their own.
constexpr std::uint32_t ftdi_divisor(int baud) {
  constexpr std::uint32_t eighth_code[] = {0, 3, 2, 4, 1, 5, 6, 7};
  if (baud >= 3'000'000) return 0;
  if (baud >= 2'000'000) return 1;
  const std::uint32_t eighths = (24'000'000u + static_cast<std::uint32_t>(baud) / 2) / static_cast<std::uint32_t>(baud);
  return eighths >> 3 | eighth_code[eighths & 7] << 14;
}

}  // namespace tactel::hw
