// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <memory>

#include "host/commands/live/live_server.h"
#include "host/commands/live/monitor.h"

namespace tactel::host {

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
