// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/bound.h"

#include <algorithm>
#include <cmath>

namespace tactel::infer {
namespace {

std::size_t place_among(const std::vector<float>& edges, float value) noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(edges, [value](float edge) { return value > edge; }));
}

/// |(scaled - centre) * whitening|^2, in the order of nn::squared_distance.
float squared_distance(const FileBound& bound, const float* scaled) noexcept {
  const std::size_t inputs = bound.centre.size();
  float sum = 0;
  constexpr std::size_t some = 64;  // of the product at a time
  for (std::size_t first = 0; first < inputs; first += some) {
    const std::size_t count = std::min(some, inputs - first);
    float product[some] = {};
    const float* row = bound.whitening.data() + first;
    for (std::size_t j = 0; j < inputs; ++j, row += inputs) {
      const float x = scaled[j] - bound.centre[j];
      for (std::size_t i = 0; i < count; ++i) product[i] += x * row[i];
    }
    for (std::size_t i = 0; i < count; ++i) sum += product[i] * product[i];
  }
  return sum;
}

}  // namespace

FrameClass classify(const FileBound& bound, const float* scaled) noexcept {
  const std::size_t tactels = bound.tactels;
  float largest = 0;
  for (std::size_t k = 0; k < tactels; ++k) largest = std::max(largest, std::abs(scaled[k]));
  FrameClass frame;
  for (std::size_t k = 0; k < tactels; ++k) frame.touching += std::abs(scaled[k]) > touching_share * largest;
  frame.unlike = squared_distance(bound, scaled) > bound.unlike_above;
  return frame;
}

void add_bound(const FileBound& bound, const FrameClass& frame, const Quantiles& q, Answer& answer) noexcept {
  const std::size_t t = place_among(bound.touching, static_cast<float>(frame.touching));
  const std::size_t s = place_among(bound.slip_index, q.median), w = place_among(bound.width, q.upper - q.lower);
  const std::size_t which = (t * (bound.slip_index.size() + 1) + s) * (bound.width.size() + 1) + w;
  const float widening = bound.interval_correction[which];
  const auto above = [&q](float end) { return std::min(std::max(end, q.median), 1.0f); };
  answer.slip_upper = above(q.upper + bound.upper_correction[which]);
  answer.slip_interval[0] = std::max(std::min(q.lower - widening, q.median), -1.0f);
  answer.slip_interval[1] = above(q.upper + widening);
  answer.unlike = frame.unlike;
}

}  // namespace tactel::infer
