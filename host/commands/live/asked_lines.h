// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "host/live/live_monitor.h"

namespace tactel::host {

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

}  // namespace tactel::host
