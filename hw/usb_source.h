#pragma once
#include <memory>

#include "hw/frame_source.h"
#include "hw/usb_device.h"

namespace tactel::hw {

/// Opens a device. Throws SourceError when it is not there or may not be opened, with what to check.
std::unique_ptr<FrameSource> open_usb(const UsbDevice& device);

}  // namespace tactel::hw
