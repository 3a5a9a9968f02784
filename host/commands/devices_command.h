#pragma once
#include <ostream>
#include <span>
#include <string>

#include "host/device/device.h"

namespace tactel::host {

/// `tactel devices`: a table of all devices, or JSON, on `out`. Returns the exit code: 0, or 3 when there is no device
/// (what to install goes to `complaints`).
int devices_command(bool json, std::ostream& out, std::ostream& complaints);

/// Index, name, type, lanes and precision of each, one a line; `*` marks the one taken by default.
std::string devices_table(std::span<const DeviceInfo> devices);
/// [{"index", "name", "platform", "driver", "type", "compute_units", "fp64", "lanes": {"fp32", "fp64"}, "low_latency",
/// "default"}]
std::string devices_json(std::span<const DeviceInfo> devices);

}  // namespace tactel::host
