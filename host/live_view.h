#pragma once
#include <chrono>
#include <string>

#include "host/live_monitor.h"

namespace tactel::host {

/// S as a bar and the tactels' stresses as strips, three lines for a terminal.
std::string view_text(const MonitorLine& line, float largest_stress);

/// Shows the latest frame on stdout, some twenty times a second, in the same place.
class LiveView {
 public:
  void show(const MonitorLine& line);
  void finish();  ///< leaves the cursor below

 private:
  std::chrono::steady_clock::time_point last_{};
  float largest_stress_ = 1e-6f;  ///< MPa, so far: what a full block stands for
  bool shown_ = false;
};

}  // namespace tactel::host
