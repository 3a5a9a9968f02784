// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <limits>

namespace tactel::host {

/// An alarm with hysteresis: it begins at a value of at least the threshold, and ends at one below threshold - release.
/// NaN changes nothing. It does not begin at a frame whose interval of S is wider than `widest`: such a frame cannot
/// tell.
class Alarm {
 public:
  static constexpr float release = 0.05f;
  explicit Alarm(float threshold, float widest = std::numeric_limits<float>::infinity())
      : threshold_(threshold), widest_(widest) {}

  /// Returns whether the alarm is on, given the next value and the width of the interval of S.
  bool next(float value, float width = 0) {
    if (value >= threshold_ && width <= widest_) on_ = true;
    if (value < threshold_ - release) on_ = false;
    cannot_tell_ = !on_ && value >= threshold_;
    return on_;
  }
  bool on() const { return on_; }
  /// Returns whether the last value began no alarm only because of its width.
  bool cannot_tell() const { return cannot_tell_; }

 private:
  float threshold_, widest_;
  bool on_ = false, cannot_tell_ = false;
};

}  // namespace tactel::host
