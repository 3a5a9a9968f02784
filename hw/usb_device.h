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

/// How to find and open a device.
struct UsbDevice {
  std::uint16_t vendor = 0, product = 0;
  Transport transport = Transport::bulk;
  int interface =
      -1;  ///< whose IN endpoint carries frames; -1: the first interface with a bulk or interrupt IN endpoint
  int endpoint = -1;                  ///< address; -1: the first IN endpoint of that interface, by descriptor
  int baud = 115200;                  ///< of a serial port behind the bridge
  std::vector<std::uint8_t> start{};  ///< bytes sent once it is open
};

}  // namespace tactel::hw
