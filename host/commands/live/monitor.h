// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/commands/live/live_server.h"
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

/// Lines "rest", or empty ones, and "slides" on standard input.
class AskedLines {
 public:
  /// frames: they come by standard input, too.
  AskedLines(bool frames, bool quiet) : open_(!frames), quiet_(quiet) {}
  /// Returns what came since the last call. Waits for nothing.
  MonitorCalls operator()();

 private:
  void take(MonitorCalls& asked) const;

  bool open_, quiet_;
  std::string line_;
};

/// The page of --serve and its lines: 33 a second, and events. None where it was not asked for.
class BrowserView {
 public:
  BrowserView(const MonitorRequest& request, const SensorProfile& profile, const char* target, bool bound);
  /// event: the line is sent, however recent the last one is.
  template <class Text>
  void show(const Text& text, bool event) {
    if (!server_) return;
    const auto now = std::chrono::steady_clock::now();
    if (!event && now - last_ < refresh) return;
    last_ = now;
    server_->send(text());
  }
  /// Tells pages that nothing has come for so many seconds.
  void tell_silence(double seconds);

 private:
  static constexpr const char* default_place = "8080";
  static constexpr auto refresh = std::chrono::milliseconds(30);
  std::unique_ptr<LiveServer> server_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace tactel::host
