// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace tactel::infer {

/// `at` of an alarm of `moved` over the largest of a hold; half of P elsewhere is no hold.
inline constexpr double hold_margin = 1.2, most_moved = 0.5;
/// Least `at` of an alarm of `slid` after a hold: 0.1 % of the elastic limit is no slide.
inline constexpr double least_slid = 0.001;

/// The stresses of a sensor while a grip rests, and how far later frames have moved from them.
///
/// Rest is sought from touch-down on, and is the mean of the first frames in which nothing moves. There are ten or
/// more, and a quarter as many as there were frames since touch-down until then: a slow press has no rest on its way at
/// any rate of frames; 500 frames are enough. Nothing moves where a frame differs from the first of them by at most 1 %
/// of P, or by at most twice the difference of neighbouring frames, which is noise. On two uSkin pads at rest that
/// difference is at most 0.65 % of P. Rest is sought anew after a release, three frames without contact in a row or
/// fewer and then less than half of P, and where P has doubled: then it is another grip.
class RestReference {
 public:
  /// inputs: numbers of a frame, of which the first `normals` are normal stresses. least: MPa, above 0: the sum of the
  /// normal stresses at rest is this at least.
  RestReference(std::size_t inputs, std::size_t normals, double least);

  /// Takes the next frame [inputs] MPa. A frame that is not finite is ignored. Allocates nothing. Returns its
  /// difference from rest: the Euclidean norm of those of all stresses, over P at rest, the sum of the normal stresses;
  /// NaN without contact or rest.
  float next(std::span<const float> frame, bool touches) noexcept;
  bool found() const noexcept { return found_; }
  /// Writes the rest [inputs] MPa; zeros where none is found.
  void write(float* rest) const noexcept;
  /// Seeks rest anew from the next frame on.
  void forget() noexcept;

 private:
  double force(std::span<const float> frame) const noexcept;
  void begin(std::span<const float> frame) noexcept;
  void seek(std::span<const float> frame) noexcept;

  std::size_t normals_;
  double least_;
  std::vector<double> sum_;          ///< [inputs] MPa, over the frames in which nothing moves; the mean once found
  std::vector<float> first_, last_;  ///< [inputs] MPa: the first of them; the newest frame
  double force_ = 0;                 ///< MPa, of the first of them; at rest once found
  double steps_ = 0;                 ///< sum of the squared differences of neighbouring ones
  int moving_ = 0;                   ///< frames since touch-down before them
  int still_ = 0;                    ///< their number; 0: nothing touches
  int apart_ = 0;                    ///< frames without contact in a row
  int tightening_ = 0;               ///< frames in a row in which P is a tenth above that at rest
  bool found_ = false;
};

}  // namespace tactel::infer
