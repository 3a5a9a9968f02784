// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "host/live/sensor_profile.h"
#include "hw/frame_source.h"

namespace tactel::host {

/// What is read from recordings of grips that hold.
struct HoldReport {
  hw::RecordedHold hold;
  double largest = 0;  ///< of D by the covariance of the hold
  std::vector<std::string> warnings{};
};

/// Learns how a hand trembles that holds, from the frames of all pads and recordings whose rest is known.
///
/// C = (N H + n G) / (N + n), of the N frames' mean H of d d' (its off-diagonal numbers by 0.9), and n frames, 1.5 s,
/// of other holders, G of the profile. at = (2.2 + 2 s / S) times the largest D of a hold of S s
/// (of 4 s and more its 0.99 quantile).
class HoldLearner {
 public:
  /// profile: with the zero that was tared; it must outlive this.
  explicit HoldLearner(const SensorProfile& profile) : profile_(profile) {}
  /// Reads a recording of the same sensor, whose name errors have. Throws SourceError where it has no rest, and where
  /// an object moves.
  void read(hw::FrameSource& source, const std::string& name);
  /// Throws SourceError where there is less than a second.
  HoldReport learn() const;

 private:
  std::vector<double> covariance() const;
  double largest(const std::vector<double>& covariance) const;

  const SensorProfile& profile_;
  std::size_t moments_ = 0;
  std::vector<float> changes_;  ///< [frames][moments] d, of all pads
  double seconds_ = 0, rate_ = 0, most_left_ = 0;
};

/// Reads how each pad slides in a recording, Q / P with its torque: the median of the frames of 0.85 and more of its
/// 0.98 quantile. Throws SourceError where a pad does not slide.
std::vector<double> read_slide(hw::FrameSource& source, const SensorProfile& profile, const std::string& name);

}  // namespace tactel::host
