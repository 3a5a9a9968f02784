// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/rest_reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tactel::infer {
namespace {

constexpr double still_share = 0.01, noises = 2, tighter = 1.1, another_grip = 2;
constexpr int fewest = 10, share = 4, enough = 500, released = 3;  // frames

/// Squared Euclidean norm of the difference.
template <class Number>
double apart(std::span<const float> a, const std::vector<Number>& b) noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - double{b[k]}) * (a[k] - double{b[k]});
  return sum;
}

}  // namespace

RestReference::RestReference(std::size_t inputs, std::size_t normals, double least)
    : normals_(normals), least_(least), sum_(inputs), first_(inputs), last_(inputs) {}

double RestReference::force(std::span<const float> frame) const noexcept {
  double sum = 0;
  for (const float stress : frame.first(normals_)) sum += stress;
  return std::abs(sum);
}

void RestReference::forget() noexcept { found_ = false, still_ = moving_ = apart_ = tightening_ = 0; }

void RestReference::write(float* rest) const noexcept {
  std::ranges::transform(sum_, rest, [&](double mean) { return found_ ? static_cast<float>(mean) : 0.0f; });
}

void RestReference::begin(std::span<const float> frame) noexcept {
  moving_ = std::min(moving_ + still_, share * enough);
  still_ = 1, steps_ = 0, force_ = force(frame);
  std::ranges::copy(frame, first_.begin());
  std::ranges::copy(frame, sum_.begin());
}

void RestReference::seek(std::span<const float> frame) noexcept {
  if (still_ == 0) return begin(frame);
  steps_ += apart(frame, last_);
  const double noise = noises * std::sqrt(steps_ / still_);
  if (std::sqrt(apart(frame, first_)) > std::max(still_share * force_, noise)) return begin(frame);
  ++still_;
  for (std::size_t k = 0; k < frame.size(); ++k) sum_[k] += frame[k];
  if (still_ < std::clamp(moving_ / share, fewest, enough)) return;
  double sum = 0;
  for (std::size_t k = 0; k < frame.size(); ++k) sum += (sum_[k] /= still_) * (k < normals_ ? 1 : 0);
  force_ = std::abs(sum);
  found_ = force_ >= least_;
  if (!found_) still_ = 0;
}

float RestReference::next(std::span<const float> frame, bool touches) noexcept {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  if (!std::ranges::all_of(frame, [](float s) { return std::isfinite(s); })) return none;
  if (!touches) {
    if (++apart_ >= released) forget();
    return none;
  }
  const double grip = force(frame);
  if (std::exchange(apart_, 0) > 0 && (!found_ || grip < force_ / another_grip)) forget();
  if (found_) {
    tightening_ = grip > tighter * force_ ? std::min(tightening_ + 1, share * enough) : 0;
    if (grip > another_grip * force_) found_ = false, still_ = 0, moving_ = std::exchange(tightening_, 0);
  }
  if (!found_) seek(frame);
  std::ranges::copy(frame, last_.begin());
  return found_ ? static_cast<float>(std::sqrt(apart(frame, sum_)) / force_) : none;
}

}  // namespace tactel::infer
