// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/device/device.h"
#include "host/support/errors.h"

namespace tactel::host {

/// Refuses a driver whose kernels left answers unwritten, which were marked before.
[[noreturn]] inline void refuse_unwritten(const Device& device) {
  throw DeviceError("a kernel", "it left answers unwritten", device.info().name,
                    "its OpenCL driver computes wrongly: choose another --device, or compute on the host");
}

}  // namespace tactel::host
