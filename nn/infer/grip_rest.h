// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactel::infer {

/// The rest of a grip that follows the hand: the mean of the last third of a second in which nothing moved.
///
/// e is the rms distance of the frames of that time from their mean, of a tactel over the mean normal stress. The hand
/// is still where e is at most three times the least e since touch-down, or 0.024 where that is less, but never above
/// 0.2: a robot's pads show 0.004, a hand's 0.016 to 0.07. Each such time is the new rest, whatever P, the sum of the
/// normal stresses, does; it stays while the hand moves. The hand opens while P is below half of that a third of a
/// second ago, or three quarters of that a twelfth ago. The rest is forgotten after three frames without contact, and
/// where P falls below a tenth of that at rest: what touches then is the memory of the rubber, until P has doubled
/// again.
class GripRest {
 public:
  /// inputs: numbers of a frame, of which the first `normals` are normal stresses, compression below 0. hz: of frames;
  /// those of more than 90 Hz are taken by the mean of some.
  GripRest(std::size_t inputs, std::size_t normals, double hz);

  /// Takes the next frame [inputs] MPa, all finite. Allocates nothing.
  void next(std::span<const float> frame, bool touches) noexcept;
  /// Says that frames come at another rate, Hz.
  void rate(double hz) noexcept;
  void forget() noexcept;

  bool found() const noexcept { return found_; }
  bool released() const noexcept { return opens_ || open_; }      ///< the hand opens, or has opened
  std::span<const float> mean() const noexcept { return rest_; }  ///< [inputs] MPa, of the rest

  double tremor() const noexcept { return tremor_; }  ///< e at rest, its running mean

 private:
  void close_bin(double force) noexcept;
  void look() noexcept;

  static constexpr std::size_t most_bins = 40;
  std::size_t inputs_, normals_;
  double rate_ = 0;                         ///< Hz
  int stride_ = 1;                          ///< frames of a bin
  std::size_t wanted_ = 20;                 ///< bins of the window
  std::vector<float> ring_;                 ///< [most_bins][inputs] MPa, means of bins
  std::array<double, most_bins> forces_{};  ///< MPa, P at the end of bins
  std::vector<double> sum_;                 ///< [inputs] MPa, of the bin at hand; scratch of look()
  std::vector<float> rest_;                 ///< [inputs] MPa
  std::size_t bins_ = 0;                    ///< since touch-down
  int frames_ = 0, apart_ = 0;              ///< of the bin at hand; without contact in a row
  double force_ = 0;                        ///< MPa, P at rest
  double least_ = 0, tremor_ = 0;           ///< of e
  double floor_ = 0;                        ///< MPa, the least P since the hand has opened
  bool found_ = false, opens_ = false, open_ = false;
};

}  // namespace tactel::infer
