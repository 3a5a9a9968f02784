// SPDX-License-Identifier: Apache-2.0
#pragma once
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

}  // namespace tactel::hw
