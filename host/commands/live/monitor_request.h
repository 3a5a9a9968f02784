// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/commands/live/sensor_session.h"
#include "host/live/live_monitor.h"

namespace tactel::host {

/// Options of tactel monitor.
struct MonitorRequest : SensorRequest {
  std::vector<std::string> networks;
  std::string device;
  int every = 1;
  std::vector<std::string> alarm_given;  ///< of --alarm: none, or a number, or "" for that of the calibration
  std::optional<float> alarm;            ///< default_alarm for --view where not given
  std::optional<float> widest;
  std::string unlike = "alarm", signal;  ///< signal: empty for slip, or without a network for moved
  MonitorOptions options;
  bool view = false, stresses = false, takes_friction = false;  ///< takes_friction: of a network
  std::vector<std::string> serve{};                             ///< of --serve: none, or a place, or ""
  std::vector<std::string> serve_hosts{};
};
void add_monitor_options(CLI::App& command, MonitorRequest& request);

}  // namespace tactel::host
