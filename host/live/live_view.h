// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "host/live/live_monitor.h"

namespace tactel::host {

struct ViewOptions {
  float alarm = 0.8f;             ///< S at the mark, and from which S is red
  bool cursor = false;            ///< each picture replaces the previous one, by escape sequences
  bool colour = false;            ///< S in green, yellow (three quarters of the alarm) or red, by escape sequences
  std::vector<PadLayout> pads{};  ///< none: a line
};

/// The largest S of each quarter of a second, the newest last.
class SlipTrace {
 public:
  static constexpr double seconds_per_column = 0.25;
  /// Adds S at an arrival time in s; S that is not finite leaves a gap. Keeps the newest `longest` columns.
  void add(double arrival, float slip_index, std::size_t longest);
  const std::deque<float>& columns() const { return columns_; }  ///< NaN: no S in this quarter of a second

 private:
  std::deque<float> columns_;
  std::int64_t newest_ = 0;  ///< number of the last column since arrival 0
};

/// Returns a line's frame as six lines of at most `columns` (at least 20) characters: S as a bar with a mark at the
/// alarm, the history of S, the stresses of the tactels as blocks of proportional height, and an arrow below each
/// shear. The arrow shows the direction in which the rubber is dragged, toward +x or -x. A tactel takes as many columns
/// as there is room for. Where the tactels exceed the columns, neighbours share one, which shows the largest of them.
///
/// A pad's frame shows tiles instead of the stresses, with y upwards: two lines of characters whose shade is the normal
/// stress, and an arrow of the shear, double from 3/16 of a full block on. Pads stand side by side where they fit;
/// tactels beyond the last column are left out.
/// largest_stress: MPa of a full block.
/// note: stands first in the last line.
std::string view_text(const MonitorLine& line, const SlipTrace& history, float largest_stress, int columns,
                      const ViewOptions& options, const std::string& note = "");

/// Draws the latest frame, some twenty times a second.
class LiveView {
 public:
  explicit LiveView(const ViewOptions& options) : options_(options) {}
  /// Returns the text for this frame; none while the last picture is recent.
  std::optional<std::string> show(const MonitorLine& line, int columns);
  /// Returns the text for the newest frame; none where it was shown.
  std::optional<std::string> show_newest(int columns);

 private:
  std::string picture(const MonitorLine& line, int columns);

  ViewOptions options_;
  SlipTrace history_;
  std::optional<MonitorLine> waiting_;  ///< the newest frame, not yet shown; of the stresses in stresses_
  std::vector<float> stresses_;         ///< [places of the channel map] MPa
  std::chrono::steady_clock::time_point last_{};
  float largest_stress_ = 1e-6f;  ///< MPa of a full block: the largest stress so far
  std::ptrdiff_t lines_ = 0;      ///< of the last picture
  std::string note_;              ///< of the last drift
};

}  // namespace tactel::host
