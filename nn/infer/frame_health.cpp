// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>

#include "nn/infer/sensor_frames.h"

namespace tactel::infer {
namespace {

constexpr int fewest_same = 10, fewest_changed = 20;  // frames
constexpr double most_pull = 1.0 / 3;                 // of the sum of the normal stresses' sizes

}  // namespace

CannotTell FrameHealth::next(std::span<const float> frame) noexcept {
  const bool same = std::memcmp(frame.data(), last_.data(), frame.size_bytes()) == 0;  // the bits: NaN is itself
  if (same) {
    ++same_;
  } else {
    longest_ = std::max(longest_, same_);
    same_ = 0, changed_ = std::min(changed_ + 1, fewest_changed);
    std::ranges::copy(frame, last_.begin());
  }
  if (!std::ranges::all_of(frame, [](float s) { return std::isfinite(s); })) return CannotTell::not_a_number;
  if (changed_ >= fewest_changed && same_ > std::max(2 * longest_, fewest_same)) return CannotTell::frozen;
  double sum = 0, size = 0;
  for (const float s : frame.first(normals_)) sum += s, size += std::abs(s);
  return sum > most_pull * size ? CannotTell::wrong_sign : CannotTell::none;
}

}  // namespace tactel::infer
