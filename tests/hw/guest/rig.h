// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "tests/hw/guest/device_model.h"

namespace tactel::hw::tests {

/// Brings a model to the kernel as a real device, under a real host controller driver. Needs root and the modules.
class Rig {
 public:
  virtual ~Rig() = default;
  /// Returns once the kernel has configured the device. Throws std::runtime_error.
  virtual void plug_in() = 0;
  /// Returns once the kernel has noticed.
  virtual void unplug() = 0;
};

/// vhci-hcd: the kernel talks to this process as if to a machine that shares its devices.
std::unique_ptr<Rig> vhci_rig(DeviceModel& model);
/// dummy_hcd: the kernel's own gadget on one end of a cable, its host controller on the other (FunctionFS).
std::unique_ptr<Rig> gadget_rig(DeviceModel& model);

/// The device's folder in /sys/bus/usb/devices; empty while there is none that is configured.
std::string device_folder();
/// Waits until it is there, or gone. Throws std::runtime_error after a time that only a hung kernel takes.
void wait_for_device(bool there);

}  // namespace tactel::hw::tests
