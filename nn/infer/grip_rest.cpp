// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/grip_rest.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactel::infer {
namespace {

constexpr double window = 1.0 / 3, finest = 60;                        // s; Hz, of bins
constexpr std::size_t fewest_bins = 10;                                // fewer show one swing of a tremor
constexpr double calmer = 3, always_still = 0.024, never_still = 0.2;  // of the least e
constexpr double opening = 0.5, fast_opening = 0.75;                   // of P a window ago; a quarter of it ago
constexpr double opened = 0.1, closed = 2;                             // of P at rest; of the least since
constexpr double tremor_time = 0.55;                                   // s
constexpr int released_frames = 3;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

}  // namespace

GripRest::GripRest(std::size_t inputs, std::size_t normals, double hz)
    : inputs_(inputs), normals_(normals), ring_(most_bins * inputs), sum_(inputs), rest_(inputs) {
  rate(hz);
  forget();
}

void GripRest::rate(double hz) noexcept {
  const int stride = std::max(1, static_cast<int>(std::lround(hz / finest)));
  if (stride != stride_) frames_ = 0, bins_ = 0;
  stride_ = stride, rate_ = hz;
  const auto bins = static_cast<std::size_t>(std::lround(window * hz / stride));
  wanted_ = std::clamp(bins, fewest_bins, most_bins);
}

void GripRest::forget() noexcept {
  bins_ = 0, frames_ = 0, apart_ = 0, found_ = opens_ = open_ = false;
  least_ = never_still, tremor_ = none;
}

void GripRest::next(std::span<const float> frame, bool touches) noexcept {
  double force = 0;
  for (const float stress : frame.first(normals_)) force -= stress;
  if (!touches) {
    if (++apart_ < released_frames) return;
    const bool was_held = bins_ > 0 || open_;
    forget();
    open_ = was_held, floor_ = 0, apart_ = released_frames;
    return;
  }
  apart_ = 0;
  if (found_ && force < opened * force_) forget(), open_ = true, floor_ = force;
  if (open_) {
    floor_ = std::min(floor_, force);
    if (force <= closed * std::max(floor_, 0.0)) return;
    open_ = false;
  }
  const auto before = [&](std::size_t bins) { return bins_ >= wanted_ ? forces_[(bins_ - bins) % most_bins] : 0.0; };
  const double least = std::max(opening * before(wanted_), fast_opening * before(wanted_ / 4));
  opens_ = least > 0 && force < least;
  if (frames_ == 0) std::ranges::fill(sum_, 0.0);
  for (std::size_t k = 0; k < inputs_; ++k) sum_[k] += frame[k];
  if (++frames_ == stride_) close_bin(force);
}

void GripRest::close_bin(double force) noexcept {
  float* const bin = &ring_[bins_ % most_bins * inputs_];
  for (std::size_t k = 0; k < inputs_; ++k) bin[k] = static_cast<float>(sum_[k] / frames_);
  forces_[bins_ % most_bins] = force;
  frames_ = 0, ++bins_;
  if (bins_ >= wanted_) look();
}

/// Whether the newest bins stand still.
void GripRest::look() noexcept {
  std::ranges::fill(sum_, 0.0);
  const auto newest = [&](std::size_t b) { return &ring_[(bins_ - 1 - b) % most_bins * inputs_]; };
  for (std::size_t b = 0; b < wanted_; ++b)
    for (std::size_t k = 0; k < inputs_; ++k) sum_[k] += newest(b)[k];
  double force = 0, square = 0;
  for (std::size_t k = 0; k < inputs_; ++k) {
    sum_[k] /= static_cast<double>(wanted_);
    if (k < normals_) force -= sum_[k];
  }
  for (std::size_t b = 0; b < wanted_; ++b)
    for (std::size_t k = 0; k < inputs_; ++k) square += (newest(b)[k] - sum_[k]) * (newest(b)[k] - sum_[k]);
  if (!(force > 0)) return;
  const double e = std::sqrt(static_cast<double>(normals_) * square / static_cast<double>(wanted_)) / force;
  least_ = std::min(least_, e);
  if (e > std::clamp(calmer * least_, always_still, never_still)) return;
  const double share = 1 - std::exp(-stride_ / (tremor_time * rate_));
  tremor_ = found_ ? tremor_ + share * (e - tremor_) : e;
  found_ = true, force_ = force;
  std::ranges::copy(sum_, rest_.begin());
}

}  // namespace tactel::infer
