// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "hw/wire_format.h"

namespace tactel::hw {

enum class Transport {
  bulk,     ///< bulk or interrupt endpoint, nothing to set up
  cdc_acm,  ///< a serial port by the CDC class: line coding, DTR
  ftdi      ///< FTDI bridge: latency timer 1 ms, two status bytes before each packet
};

/// Port and serial number, which distinguish devices of one vendor and product.
struct UsbPlace {
  std::string port;    ///< bus and ports from its root, "1-2.3", as in /sys/bus/usb/devices
  std::string serial;  ///< printable characters only; empty: none, or not readable
};

std::string place_text(const UsbPlace& place);  ///< "port 1-2.3 (serial number A7)"

/// Data with which a device is found and opened.
struct UsbDevice {
  std::uint16_t vendor = 0, product = 0;
  Transport transport = Transport::bulk;
  int interface =
      -1;  ///< whose IN endpoint carries frames; -1: the first interface with a bulk or interrupt IN endpoint
  int endpoint = -1;                  ///< address; -1: the first IN endpoint of that interface, by descriptor
  int baud = 115200;                  ///< of a serial port behind the bridge
  std::vector<std::uint8_t> start{};  ///< bytes sent after opening
  double wait = 0;                    ///< s between the two
  std::string port{}, serial{};       ///< as UsbPlace: one of several devices; empty: the first free one
};

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
