// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/grip_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace tactel::infer {
namespace {

constexpr double least_change = 0.062, tremors = 3.9;                // of patterns of pressure and shear
constexpr double least_pressure = 0.0713, pressure_tremors = 4.485;  // of pressure alone
constexpr double slide_time = 1.0 / 3;                               // s
constexpr std::size_t most_slide_frames = 512;

float median(float a, float b, float c) noexcept { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

}  // namespace

std::vector<double> whitening(std::span<const float> covariance, std::size_t n) {
  std::vector<double> factor(n * n), inverse(n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = covariance[i * (i + 1) / 2 + j];
      for (std::size_t k = 0; k < j; ++k) sum -= factor[i * n + k] * factor[j * n + k];
      if (i == j && !(sum > 0)) return {};
      factor[i * n + j] = i == j ? std::sqrt(sum) : sum / factor[j * n + j];
    }
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = j; i < n; ++i) {
      double sum = i == j ? 1 : 0;
      for (std::size_t k = j; k < i; ++k) sum -= factor[i * n + k] * inverse[k * n + j];
      inverse[i * n + j] = sum / factor[i * n + i];
    }
  return inverse;
}

GripScore::GripScore(const PadShape& shape, const AlarmOptions& options, double touch)
    : moments_(shape),
      rest_(shape.tactels * shape.axes, shape.tactels, options.rate),
      frames_(3 * shape.tactels * shape.axes),
      median_(shape.tactels * shape.axes),
      whole_(median_.size()),
      at_(options.held.at),
      touch_(touch),
      slide_(options.slide),
      root_tactels_(std::sqrt(static_cast<double>(shape.tactels))),
      sheared_(shape.axes > 1),
      frictions_(most_slide_frames) {
  rate(options.rate);
  const std::size_t n = moments_.count();
  if (at_ > 0) inverse_ = whitening(std::span(options.held.covariance).first(n * (n + 1) / 2), n);
}

void GripScore::rate(double hz) noexcept {
  rest_.rate(hz);
  wanted_ = static_cast<std::size_t>(std::clamp(slide_time * hz, 1.0, double{most_slide_frames}));
}

/// Of the last three frames of this contact, without the first repetition of one: it would let a spike that is repeated
/// through. Of fewer, or where one has no number, the newest.
void GripScore::take_median(std::span<const float> frame, bool touches) noexcept {
  const std::size_t n = frame.size();
  const auto newest = [&] { return &frames_[(taken_ - 1) % 3 * n]; };
  if (!touches) taken_ = 0;
  const bool repeats = taken_ > 0 && std::memcmp(newest(), frame.data(), frame.size_bytes()) == 0;
  if ((repeated_ = repeats && !repeated_)) return;
  std::ranges::copy(frame, &frames_[taken_++ % 3 * n]);
  for (std::size_t k = 0; k < n; ++k) {
    const float a = frames_[k], b = frames_[n + k], c = frames_[2 * n + k];
    median_[k] = taken_ >= 3 && std::isfinite(a + b + c) ? median(a, b, c) : frame[k];
    if (std::isfinite(median_[k])) whole_[k] = median_[k];
  }
}

/// Of the newest change.
double GripScore::score() const noexcept {
  const double tremor = rest_.tremor();
  if (!sheared_) return change_.pressure / std::max(least_pressure, pressure_tremors * tremor);
  return std::sqrt(change_.pressure * change_.shear) / std::max(least_change, tremors * tremor);
}

GripReading GripScore::next(std::span<const float> frame, bool touches) noexcept {
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  take_median(frame, touches);
  rest_.next(whole_, touches);
  GripReading said{rest_.found(), rest_.released(), nothing, nothing, nothing, nothing, nothing};
  const bool held = touches && (said.rest || !said.released);
  const bool earnestly = held && moments_.force(median_) >= earnest * touch_;
  touched_ = earnestly ? touched_ + 1 : 0;
  if (earnestly) {
    const double friction = moments_.friction(median_);
    frictions_[touched_ % most_slide_frames] = static_cast<float>(friction);
    if (slide_ > 0) said.index = static_cast<float>(friction / slide_);
  }
  if (!held || !said.rest) return said;
  change_ = moments_.change(median_, rest_.mean());
  said.calm = static_cast<float>(rest_.tremor() / root_tactels_), said.moved = static_cast<float>(change_.moved);
  said.score = static_cast<float>(score());
  const std::span<const double> moments(change_.moments);
  said.of_hold = at_ > 0 ? static_cast<float>(norm(inverse_, moments.first(moments_.count())) / at_) : 0;
  return said;
}

float GripScore::slides() noexcept {
  const std::size_t count = std::min(touched_, wanted_);
  if (count == 0) return std::numeric_limits<float>::quiet_NaN();
  std::array<float, most_slide_frames> last;
  for (std::size_t i = 0; i < count; ++i) last[i] = frictions_[(touched_ - i) % most_slide_frames];
  const auto middle = last.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(last.begin(), middle, last.begin() + static_cast<std::ptrdiff_t>(count));
  slide_ = *middle;
  return *middle;
}

void GripScore::clear() noexcept { rest_.forget(), taken_ = touched_ = 0; }

}  // namespace tactel::infer
