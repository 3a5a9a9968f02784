#pragma once
#include <span>
#include <vector>

namespace tactel::hw {

/// What turns a channel's reading into a stress: (reading - offset) gain.
struct Calibration {
  std::vector<double> offset;  ///< [channels] reading at rest, the device's units
  std::vector<double> gain;    ///< [channels] MPa by the device's unit; negative where the reading falls under tension
};

/// Which channel is which stress of which tactel, and how its readings become MPa. -1: no channel, the stress is 0.
struct ChannelMap {
  std::vector<int> normal, shear;  ///< [tactels] channel
  Calibration calibration;

  std::size_t tactels() const { return normal.size(); }
  void validate(std::size_t channels) const;  ///< throws ProfileError, keys as in profile files
  /// values: [channels], the device's units. frame: [2 tactels] MPa, normal stresses first, as networks take them.
  void apply(std::span<const double> values, std::span<float> frame) const;
};

/// The mean of each channel over frames taken at rest.
class Tare {
 public:
  explicit Tare(std::size_t channels) : sum_(channels, 0.0) {}
  void add(std::span<const double> values);
  std::size_t frames() const { return frames_; }
  std::vector<double> offset() const;  ///< [channels]; zeros before the first frame

 private:
  std::vector<double> sum_;
  std::size_t frames_ = 0;
};

}  // namespace tactel::hw
