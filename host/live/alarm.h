// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tactel::host {

/// An alarm with hysteresis: it begins at a value of at least the threshold, and ends at one below threshold - release.
/// NaN changes nothing.
class Alarm {
 public:
  static constexpr float release = 0.05f;
  explicit Alarm(float threshold) : threshold_(threshold) {}

  /// Returns whether the alarm is on, given the next value.
  bool next(float value) {
    if (value >= threshold_) on_ = true;
    if (value < threshold_ - release) on_ = false;
    return on_;
  }
  bool on() const { return on_; }

 private:
  float threshold_;
  bool on_ = false;
};

}  // namespace tactel::host
