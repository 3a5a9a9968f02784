// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <optional>

namespace tactel::host {

/// The rate of frames by their times, anew each second.
class RateMeter {
 public:
  explicit RateMeter(double hz) : rate_(hz) {}
  double rate() const { return rate_; }
  /// Takes the time of the next frame, s. Returns the rate where it differs by a tenth from the last one.
  std::optional<double> next(double time) {
    if (frames_++ == 0) begin_ = time;
    const double passed = time - begin_;
    if (passed < 1) return std::nullopt;
    const double rate = (frames_ - 1) / passed;
    const bool whole = passed < 2 && frames_ > fewest;  // no pause
    begin_ = time, frames_ = 1;
    if (!whole || std::abs(rate - rate_) < 0.1 * rate_) return std::nullopt;
    return rate_ = rate;
  }

 private:
  static constexpr int fewest = 5;
  double rate_, begin_ = 0;
  int frames_ = 0;
};

}  // namespace tactel::host
