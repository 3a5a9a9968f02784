// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hw/frame_source.h"
#include "hw/usb_device.h"

namespace tactel::hw {

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
