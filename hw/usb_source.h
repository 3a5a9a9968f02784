// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hw/frame_source.h"

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

/// The opened device among several of one vendor and product.
struct UsbChoice {
  struct Other {
    UsbPlace place;
    std::string refusal{};  ///< why it was skipped; empty: not tried
  };
  UsbPlace taken{};
  std::vector<Other> others{};  ///< other connected devices, by port
};

class UsbSource : public FrameSource {
 public:
  virtual const UsbChoice& choice() const = 0;  ///< state at opening
};

/// Opens the first free device, by port, that matches `device`. Throws SourceError, with what to check, where there
/// is none or it may not be opened. After an unplug the source waits for the same device. It identifies it by its
/// serial number, or by its port where that number is not unique.
std::unique_ptr<UsbSource> open_usb(const UsbDevice& device);

/// A device that is plugged in and may send frames: one with a bulk or interrupt IN endpoint that is no hub, keyboard,
/// disk, camera or the like.
struct ListedUsb {
  std::uint16_t vendor = 0, product = 0;
  UsbPlace place{};
  std::string name{};      ///< as the device says, printable characters only; may be empty
  bool is_serial = false;  ///< a serial port by the CDC class
  std::string refusal{};   ///< why it cannot be opened; empty: it can
};

/// Returns the devices that may send frames, by port. Throws SourceError.
std::vector<ListedUsb> list_usb();

}  // namespace tactel::hw
