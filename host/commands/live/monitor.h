// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/commands/live/sensor_session.h"
#include "host/live/live_monitor.h"
#include "nn/model.h"

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

/// Returns the line of a frame as JSON. target: key of the network's answer; null without a network. tactels: of all
/// pads, where the line has their stresses; 0: it has none.
std::string line_text(const MonitorRequest& request, const MonitorLine& line, const char* target, std::size_t tactels);
/// Returns the line of a second without a frame: nobody can tell, and the alarm is as it was. arrival: s, of now.
std::string silence_text(double seconds, double arrival, bool alarm);
/// Returns the summary as JSON.
std::string summary_text(const MonitorSummary& all, bool cut_short);
/// Returns the ranges that a network learnt, as far as its file knows them; empty where it knows none.
std::string learnt_text(const nn::Learnt& learnt);
/// Returns what is said of a reading of mu.
std::string friction_text(std::span<const float> mu);

}  // namespace tactel::host
