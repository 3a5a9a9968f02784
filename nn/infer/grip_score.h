// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include <cmath>
#include <span>
#include <vector>

#include "nn/infer/grip_rest.h"
#include "nn/infer/pad_moments.h"

namespace tactel::infer {

/// What the stresses of a grip say since its rest.
struct GripReading {
  bool rest = false, released = false;
  float calm = 0, moved = 0, score = 0, of_hold = 0, index = 0;  ///< as of AlarmAnswer, NaN where there is none
};

/// How far a pad's stresses have left the rest of its grip, as a number that squeezing and easing leave at 0.
///
/// Each number of a frame is the median of three. The score is sqrt(|u| |v|), the changes of the patterns of pressure
/// and shear (Change), over 0.062 or 3.9 times the hand's tremor at rest: a slip changes both, a load mostly one. Of
/// normal stresses alone it is |u| over 0.0713 or 4.485 tremors. A recorded hold adds D / at, D = sqrt(d' C^-1 d) of
/// the moments d (PadMoments) and their covariance C in holds.
class GripScore {
 public:
  /// touch: MPa, of a normal stress.
  GripScore(const PadShape& shape, const AlarmOptions& options, double touch);
  /// Takes the next frame [inputs] MPa. Allocates nothing.
  GripReading next(std::span<const float> frame, bool touches) noexcept;
  void rate(double hz) noexcept;
  /// Remembers how the newest third of a second slides: the median of Q / P with its torque. Returns it; NaN where
  /// nothing touches.
  float slides() noexcept;
  void forget() noexcept { rest_.forget(); }
  void clear() noexcept;

  const PadMoments& moments() const noexcept { return moments_; }
  const Change& newest() const noexcept { return change_; }  ///< of the newest frame with a rest

 private:
  double score() const noexcept;
  void take_median(std::span<const float> frame, bool touches) noexcept;

  PadMoments moments_;
  GripRest rest_;
  std::vector<float> frames_;          ///< [3][inputs] MPa, the newest by turns
  std::vector<float> median_, whole_;  ///< [inputs] MPa; whole: NaN replaced by the last number
  std::size_t taken_ = 0;              ///< frames of this contact, without repetitions
  bool repeated_ = false;              ///< the newest frame was a repetition
  std::vector<double> inverse_;        ///< [moments][moments] lower triangle of the inverse of C's Cholesky factor
  double at_, touch_;                  ///< of D, 0 without a hold; MPa
  double slide_;                       ///< friction of a slide; 0: none is known
  double root_tactels_;
  bool sheared_;
  std::vector<float> frictions_;          ///< of the newest frames that touch, by turns
  std::size_t wanted_ = 0, touched_ = 0;  ///< frames of a third of a second; that touched in a row
  Change change_;
};

/// Returns the inverse of the Cholesky factor of a covariance [n (n + 1) / 2], row by row, as rows [n][n]; empty where
/// it is not positive definite.
std::vector<double> whitening(std::span<const float> covariance, std::size_t n);
/// Returns the norm of numbers [n] by a whitening [n][n].
template <class Number>
double norm(std::span<const double> white, std::span<const Number> numbers) noexcept {
  const std::size_t n = numbers.size();
  double square = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j <= i; ++j) sum += white[i * n + j] * numbers[j];
    square += sum * sum;
  }
  return std::sqrt(square);
}

inline constexpr double earnest = 10;  ///< touches: of less force no friction is read

}  // namespace tactel::infer
