// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

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

}  // namespace tactel::hw
