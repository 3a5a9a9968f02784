#pragma once
#include <chrono>
#include <optional>
#include <string>

#include "host/live/live_monitor.h"

namespace tactel::host {

/// Returns a frame as five lines of at most `columns` (at least 20) characters: S as a bar, the stresses of the
/// tactels as blocks of proportional height, and an arrow below each shear. The arrow shows the direction in
/// which the rubber is dragged, toward +x or -x. Where the tactels exceed the columns, neighbours share one,
/// which shows the largest of them. largest_stress: MPa of a full block.
std::string view_text(const MonitorLine& line, float largest_stress, int columns);

/// Draws the latest frame, some twenty times a second. On a terminal each picture replaces the previous one.
class LiveView {
 public:
  explicit LiveView(bool terminal) : terminal_(terminal) {}
  /// Returns the text for this frame; none while the last picture is recent.
  std::optional<std::string> show(const MonitorLine& line, int columns);

 private:
  std::chrono::steady_clock::time_point last_{};
  float largest_stress_ = 1e-6f;  ///< MPa of a full block: the largest stress so far
  bool terminal_, shown_ = false;
};

}  // namespace tactel::host
