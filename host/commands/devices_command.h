// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <ostream>
#include <span>
#include <string>

#include "host/device/device.h"

namespace tactel::host {

/// `tactel devices`: writes a table of all devices, or JSON, to `out`. Returns the exit code: 0, or 3 where there
/// is no device; `complaints` then receives the remedy.
int devices_command(bool json, std::ostream& out, std::ostream& complaints);

/// Returns index, name, type, lanes and precision, a line per device; `*` marks the default one.
std::string devices_table(std::span<const DeviceInfo> devices);
/// [{"index", "name", "platform", "driver", "type", "compute_units", "fp64", "lanes": {"fp32", "fp64"}, "low_latency",
/// "default"}]
std::string devices_json(std::span<const DeviceInfo> devices);

/// `tactel devices --sensors`: the USB devices that may send frames, with the --source that would read each.
int sensors_command(bool json, std::ostream& out, std::ostream& complaints);

}  // namespace tactel::host
