// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

namespace tactel::hw {

/// Conversion of the reading of a channel to a stress: (reading - offset) gain.
struct Calibration {
  std::vector<double> offset;   ///< [channels] reading at rest, in the device's units
  std::vector<double> gain;     ///< [channels] MPa by the device's unit; negative where the reading falls under tension
  std::vector<double> noise{};  ///< [channels] standard deviation at rest, in the device's units; empty: not known
};

/// Channels of the stresses of each tactel, and their calibration. -1: no channel, the stress is 0.
struct ChannelMap {
  std::vector<int> normal, shear;  ///< [tactels] channel
  Calibration calibration;

  /// A normal stress within this many standard deviations of the noise at rest is no contact. Gaussian noise of 21
  /// tactels at 1 kHz exceeds it once in 5000 hours, or once in 450 where the noise was measured 5 % too small.
  static constexpr double touch_deviations = 7;

  std::size_t tactels() const { return normal.size(); }
  int channel(std::size_t place) const;  ///< of a place in a frame [2 tactels]
  /// Returns "channel 3 (shear stress of tactel 0)", of a place with a channel.
  std::string channel_text(std::size_t place) const;
  /// Returns the largest normal stress of noise at rest, MPa: touch_deviations of the noisiest normal channel; 0 where
  /// the noise is not known.
  double touch() const;
  void validate(std::size_t channels) const;  ///< throws ValueError, keys as in profile files
  /// Converts values [channels], in the device's units, to frame [2 tactels] MPa, normal stresses first, as
  /// networks take them.
  void apply(std::span<const double> values, std::span<float> frame) const;
};

}  // namespace tactel::hw
