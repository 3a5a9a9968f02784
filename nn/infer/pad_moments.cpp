// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/pad_moments.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactel::infer {

PadMoments::PadMoments(const PadShape& shape) : tactels_(shape.tactels), axes_(shape.axes) {
  std::size_t columns = shape.columns;
  if (columns == 0) {
    const auto side = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(tactels_))));
    columns = side * side == tactels_ && axes_ != 2 ? side : tactels_;
  }
  const std::size_t rows = tactels_ / columns;
  double square = 0;
  for (std::size_t t = 0; t < tactels_; ++t) {
    const std::size_t row = t / columns;
    x_.push_back(static_cast<float>(static_cast<double>(t % columns) - 0.5 * static_cast<double>(columns - 1)));
    y_.push_back(static_cast<float>(shape.aspect * (static_cast<double>(row) - 0.5 * static_cast<double>(rows - 1))));
    square += x_[t] * x_[t] + y_[t] * y_[t];
  }
  const auto radius = static_cast<float>(square > 0 ? std::sqrt(square / static_cast<double>(tactels_)) : 1.0);
  for (float& x : x_) x /= radius;
  for (float& y : y_) y /= radius;
  const bool wide = columns > 1, high = rows > 1, has_x = axes_ > 1, has_y = axes_ > 2;
  const bool has[] = {has_x, has_y, wide, high, has_x && wide, has_x && high, has_y && wide, has_y && high};
  for (std::size_t m = 0; m < most_moments; ++m)
    if (has[m]) which_[count_++] = m;
}

/// Of the numbers of `frame` where `like` is finite.
PadMoments::Sums PadMoments::sums(std::span<const float> frame, std::span<const float> like) const noexcept {
  const auto at = [&](std::size_t k) { return std::isfinite(like[k]) ? double{frame[k]} : 0.0; };
  Sums s;
  Moments& m = s.moments;
  for (std::size_t t = 0; t < tactels_; ++t) {
    const double z = -at(t), x = x_[t], y = y_[t];
    s.force += z, m[2] += z * x, m[3] += z * y;
    if (axes_ < 2) continue;
    const double a = at(tactels_ + t);
    m[0] += a, m[4] += a * x, m[5] += a * y;
    if (axes_ < 3) continue;
    const double b = at(2 * tactels_ + t);
    m[1] += b, m[6] += b * x, m[7] += b * y;
  }
  return s;
}

Change PadMoments::change(std::span<const float> frame, std::span<const float> rest) const noexcept {
  const Sums pressed = sums(frame, frame), then = sums(rest, frame);
  const double ratio = pressed.force / then.force, most = std::max(pressed.force, then.force);
  Change change;
  for (std::size_t m = 0; m < count_; ++m)
    change.moments[m] = (pressed.moments[which_[m]] - ratio * then.moments[which_[m]]) / most;
  double moved = 0;
  const auto pattern = [&](std::size_t axis, bool less_mean) {
    double sum = 0, square = 0, count = 0;
    for (std::size_t k = axis * tactels_; k < (axis + 1) * tactels_; ++k) {
      if (!std::isfinite(frame[k])) continue;
      const double e = frame[k] / pressed.force - rest[k] / then.force, way = double{frame[k]} - rest[k];
      sum += e, square += e * e, moved += way * way, ++count;
    }
    return less_mean && count > 0 ? std::max(square - sum * sum / count, 0.0) : square;
  };
  const auto T = static_cast<double>(tactels_);
  change.pressure = std::sqrt(T * pattern(0, false));
  double shear = 0;
  for (std::size_t axis = 1; axis < axes_; ++axis) shear += pattern(axis, true);
  change.shear = std::sqrt(T * shear);
  change.moved = std::sqrt(moved) / then.force;
  return change;
}

double PadMoments::friction(std::span<const float> frame) const noexcept {
  const auto at = [&](std::size_t k) { return std::isfinite(frame[k]) ? double{frame[k]} : 0.0; };
  const auto pressure = [&](std::size_t t) { return std::max(-at(t), 0.0); };
  const Sums pressed = sums(frame, frame);
  if (!(pressed.force > 0)) return std::numeric_limits<double>::quiet_NaN();
  double all = 0, x = 0, y = 0, way = 0, torque = 0;
  for (std::size_t t = 0; t < tactels_; ++t) all += pressure(t), x += pressure(t) * x_[t], y += pressure(t) * y_[t];
  x /= all, y /= all;
  for (std::size_t t = 0; t < tactels_; ++t) {
    const double dx = x_[t] - x, dy = y_[t] - y;
    way += pressure(t) * std::hypot(dx, dy) / all;
    if (axes_ > 1) torque -= dy * at(tactels_ + t);
    if (axes_ > 2) torque += dx * at(2 * tactels_ + t);
  }
  return std::hypot(pressed.moments[0], pressed.moments[1], way > 0 ? torque / way : 0) / pressed.force;
}

}  // namespace tactel::infer
