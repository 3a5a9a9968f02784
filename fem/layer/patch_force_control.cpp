// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_force_control.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {
namespace {

// mm per mm of P / E: a start that the first trial corrects, thickness over width or so.
constexpr double first_slope = 0.3;

/// A trial within this share of Q = mu P slides as a whole. Forces do not change with x there: Broyden's update would
/// learn nothing. The next trial lies halfway to the last one that did not slide.
constexpr double sliding_margin = 1e-5;

/// A trial inside the bracket: where Broyden's step leaves it, halfway to the bound, or twice as deep where there is no
/// bound yet.
double bracketed(double trial, double depth, double low, double high) {
  if (trial >= high) return std::isfinite(high) ? (depth + high) / 2 : 2 * depth;
  return trial <= low ? (depth + low) / 2 : trial;
}

}  // namespace

PatchForceControl::PatchForceControl(double first_touch) : z_(first_touch, 0), g_(0, 0), first_touch_(first_touch) {
  inverse_ << first_slope, 0, 0, 1;
}

double PatchForceControl::start(const LoadStep& target, double depth) {
  target_ = target;
  low_ = 0;
  high_ = infinity;
  if (!(target.normal > 0)) return 0;
  return depth > first_touch_ ? depth : first_touch_ + inverse_(0, 0) * target.normal;
}

void PatchForceControl::update(const Eigen::Vector2d& z, const Eigen::Vector2d& g) {
  const Eigen::Vector2d dz = z - z_, dg = g - g_, off = dz - inverse_ * dg;
  const Eigen::RowVector2d row = dz.transpose() * inverse_;
  const double below = row * dg;
  // Steps that are too small tell nothing.
  if (std::abs(below) > 1e-2 * dz.squaredNorm()) inverse_ += off * row / below;
  z_ = z;
  g_ = g;
}

bool PatchForceControl::move(double P, double Q, double mu, double tolerance, double& depth, double& x) {
  const bool both = target_.tangential_is_force;
  const bool slides = both && P > 0 && std::abs(Q) >= (1 - sliding_margin) * mu * P;
  const double ratio = both && target_.normal > 0 ? target_.tangential / target_.normal : 0;
  const Eigen::Vector2d z(depth, x), g(P, both ? Q - ratio * P : 0), miss(P - target_.normal, g[1]);
  if (!slides) update(z, g);
  if (miss.cwiseAbs().maxCoeff() <= tolerance * target_.normal) return false;
  const Eigen::Vector2d next = z - inverse_ * miss;
  if (miss[0] < 0) low_ = std::max(low_, depth);
  if (miss[0] > 0) high_ = std::min(high_, depth);
  // P grows with the depth alone where x is given: stay inside the bracket. With both unknown the bracket moves: bound
  // the step instead.
  const double far_d = z[0] / 2, far_x = std::max(std::abs(z[1]), far_d);
  depth = both ? std::min(std::max(next[0], z[0] - far_d), z[0] + 2 * far_d) : bracketed(next[0], z[0], low_, high_);
  if (both) x = slides ? (z[1] + z_[1]) / 2 : std::min(std::max(next[1], z[1] - far_x), z[1] + far_x);
  return true;
}

}  // namespace tactel::fem
