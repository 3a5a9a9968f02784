// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

namespace tactel::hw {

/// How a hand trembles that holds.
struct RecordedHold {
  std::vector<double> covariance;            ///< [moments (moments + 1) / 2], as of tactel::HeldGrip; empty: none
  double at = 0;                             ///< as of tactel::HeldGrip; 0: of others, for tactel tare --hold
  double seconds = 0, rate = 0, margin = 0;  ///< of the hold; Hz, of its frames; at over the largest of the hold
};

/// Conversion of the reading of a channel to a stress: (reading - offset) gain.
struct Calibration {
  std::vector<double> offset;   ///< [channels] reading at rest, in the device's units
  std::vector<double> gain;     ///< [channels] MPa by the device's unit; negative where the reading falls under tension
  std::vector<double> noise{};  ///< [channels] standard deviation at rest, in the device's units; empty: not known
  bool has_zero = true;         ///< false: the readings at rest are not known, and the offsets stand as 0
  bool zero_told = false;       ///< by an offset: a gain that is told later has it, too
  double moved = 0;             ///< `at` of an alarm of AlarmSignal::moved; 0: not known
  double slid = 0;              ///< `at` of an alarm of a network of slid; 0: not known
  RecordedHold hold{};
  std::vector<double> slide{};  ///< [pads] Q / P with its torque of a slide; empty: none was recorded
};

/// Channels of the stresses of each tactel, and their calibration. -1: no channel, the stress is 0. A frame has a place
/// for each stress: all normal stresses, then all shear stresses; of a pad those along x, then those along y.
struct ChannelMap {
  std::vector<int> normal, shear;  ///< [tactels] channel; no shear: of a pad of one axis
  Calibration calibration;
  std::vector<int> shear_y{};  ///< [tactels] channel, of a pad, whose `shear` is along x

  /// A normal stress within this many standard deviations of the noise at rest is no contact. Gaussian noise of 21
  /// tactels at 1 kHz exceeds it once in 5000 hours, or once in 450 where the noise was measured 5 % too small.
  static constexpr double touch_deviations = 7;

  std::size_t tactels() const { return normal.size(); }
  std::size_t places() const { return normal.size() + shear.size() + shear_y.size(); }  ///< of a frame
  int channel(std::size_t place) const;                                                 ///< -1: none
  /// Returns "channel 3 (shear stress of tactel 0)", of a place with a channel.
  std::string channel_text(std::size_t place) const;
  /// Returns the largest normal stress of noise at rest, MPa: touch_deviations of the noisiest normal channel of
  /// `count` tactels from `first` on; 0 where the noise is not known.
  double touch(std::size_t first, std::size_t count) const;
  double touch() const { return touch(0, tactels()); }
  void validate(std::size_t channels) const;  ///< throws ValueError, keys as in profile files
  /// Converts values [channels], in the device's units, to frame [places] MPa, as networks take them.
  void apply(std::span<const double> values, std::span<float> frame) const;
};

}  // namespace tactel::hw
