// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/patch_contact_lanes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/gap/contact_laws.h"
#include "fem/layer/patch_solver.h"
#include "fem/scenes/measured_profile.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// An interval along x, mm from the indenter's position.
struct Interval {
  double left, right;
};

/// The shape's rows of `lane`. Returns its own edges; infinite where it has none.
class ShapeRows {
 public:
  explicit ShapeRows(PatchLane& lane) : lane_(lane) {}

  Interval operator()(const fem::Flat& s) {
    return s.half_width ? Interval{-*s.half_width, *s.half_width} : Interval{-infinity, infinity};
  }
  Interval operator()(const fem::Wedge& s) {
    lane_.input[PATCH_C1] = 1 / std::tan(s.edge_angle / 2 * std::numbers::pi / 180);
    return {-infinity, infinity};
  }
  Interval operator()(const fem::Parabola& s) {
    lane_.input[PATCH_C2] = 1 / (2 * s.radius);
    return {-infinity, infinity};
  }
  Interval operator()(const fem::Cylinder& s) {
    lane_.input[PATCH_RADIUS] = s.radius;
    return {-s.radius, s.radius};
  }
  Interval operator()(const fem::Exponential& s) {
    lane_.input[PATCH_EXP_HEIGHT] = s.height;
    lane_.input[PATCH_EXP_RATE] = s.rate;
    return {-infinity, infinity};
  }
  Interval operator()(const fem::Trapezoid& s) {
    lane_.input[PATCH_FLAT] = s.half_width;
    lane_.input[PATCH_C1] = s.slope;
    return {-infinity, infinity};
  }
  Interval operator()(const fem::RoundedFlat& s) {
    lane_.input[PATCH_FLAT] = s.half_width;
    lane_.input[PATCH_C2] = 1 / (2 * s.radius);
    return {-infinity, infinity};
  }
  Interval operator()(const fem::Taylor& s) {
    const double height = s.height.value_or(s.scale);
    for (std::size_t k = 0; k < s.powers.size(); ++k) {
      const double c = height * (s.coefficients.empty() ? 1 : s.coefficients[k]);
      if (s.powers[k] <= 5)
        lane_.input[PATCH_C1 + s.powers[k] - 1] += c / std::pow(s.scale, s.powers[k]);
      else
        lane_.shape.insert(lane_.shape.end(), {c, static_cast<double>(s.powers[k]), 1 / s.scale});
    }
    const std::size_t terms = lane_.shape.size() / 3;
    lane_.input[PATCH_TERMS] = static_cast<double>(terms);
    return {-infinity, infinity};
  }
  Interval operator()(const fem::Profile& s) {
    const fem::Profile hull = fem::convex_profile(s);
    for (std::size_t k = 0; k < hull.x.size(); ++k) {
      const std::size_t from = std::min(k, hull.x.size() - 2);
      const double slope = (hull.y[from + 1] - hull.y[from]) / (hull.x[from + 1] - hull.x[from]);
      lane_.shape.insert(lane_.shape.end(), {hull.x[k], hull.y[k], slope});
    }
    lane_.input[PATCH_POINTS] = static_cast<double>(hull.x.size());
    return {hull.x.front(), hull.x.back()};
  }

 private:
  PatchLane& lane_;
};

/// Where heights stay below `depth`, mm from the indenter's position, for shapes that are even and rise without end.
double half_width(const fem::Flat& s, double) { return s.half_width.value_or(infinity); }
double half_width(const fem::Wedge& s, double depth) {
  return depth * std::tan(s.edge_angle / 2 * std::numbers::pi / 180);
}
double half_width(const fem::Parabola& s, double depth) { return std::sqrt(2 * s.radius * depth); }
double half_width(const fem::Cylinder& s, double depth) {
  return depth < s.radius ? std::sqrt(depth * (2 * s.radius - depth)) : s.radius;
}
double half_width(const fem::Exponential& s, double depth) { return std::log1p(depth / s.height) / s.rate; }
double half_width(const fem::Trapezoid& s, double depth) { return s.half_width + depth / s.slope; }
double half_width(const fem::RoundedFlat& s, double depth) { return s.half_width + std::sqrt(2 * s.radius * depth); }
/// Whether the height at distance r is less than `depth`. Products decide, and pow() where their rounding could matter.
bool below(const fem::Taylor& s, double r, double depth) {
  double sum = 0;
  for (std::size_t k = 0; k < s.powers.size(); ++k) {
    double term = s.coefficients.empty() ? 1 : s.coefficients[k];
    for (int n = 0; n < s.powers[k]; ++n) term *= r / s.scale;
    sum += term;
  }
  const double height = s.height.value_or(s.scale) * sum;
  if (std::abs(height - depth) > 1e-10 * depth) return height < depth;
  return fem::profile_height({s, 0}, r) < depth;
}
double half_width(const fem::Taylor& s, double depth) {
  if (std::isinf(fem::lowest_part({s, 0}).right)) return infinity;
  double low = 0, high = s.scale;
  for (int k = 0; k < 60 && below(s, high, depth); ++k) high *= 2;
  for (int k = 0; k < 40 && high - low > 1e-9 * high; ++k) {
    const double middle = 0.5 * (low + high);
    (below(s, middle, depth) ? low : high) = middle;
  }
  return high;
}

template <class Even>
Interval below(const Even& shape, const PatchLane&, double depth) {
  const double half = half_width(shape, depth);
  return {-half, half};
}
/// From the points of the convex hull in `lane`.
Interval below(const fem::Profile&, const PatchLane& lane, double depth) {
  const auto& p = lane.shape;
  const std::size_t count = p.size() / 3;
  Interval found{p[0], p[3 * (count - 1)]};
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const double x = p[3 * k], y = p[3 * k + 1], slope = p[3 * k + 2], next = p[3 * k + 4];
    if (y > depth && next <= depth) found.left = x + (depth - y) / slope;
    if (y <= depth && next > depth) found.right = x + (depth - y) / slope;
  }
  return found;
}

}  // namespace

PatchPath patch_path(const fem::LoadPath& path, const fem::Load& load, int pressing_increments) {
  PatchPath refined;
  refined.steps = fem::patch_steps(path, load, pressing_increments);
  refined.slots = static_cast<int>(path.steps.size());
  refined.indentation_slots = path.indentation_steps;
  refined.until_sliding = path.until_sliding;
  for (int slot = 0; slot < refined.indentation_slots; ++refined.pressing_increments)
    slot += refined.steps[refined.pressing_increments].asked;
  for (const fem::LoadStep& step : path.steps) refined.most = std::max(refined.most, step.normal);
  return refined;
}

PatchLane patch_lane(const fem::Scene& scene, const PatchPath& path, const std::optional<PatchContactExtent>& given) {
  PatchLane lane;
  double* in = lane.input;
  const fem::Indenter& indenter = scene.indenter;
  const bool force = by_force(scene);
  in[PATCH_MU] = std::min(scene.friction, fem::largest_friction);
  in[PATCH_YOUNG] = scene.sensor.young;
  in[PATCH_STEPS] = static_cast<double>(path.steps.size());
  in[PATCH_MAY_STOP] = path.until_sliding ? path.pressing_increments : 1e6;
  in[PATCH_CONTROL] = force ? (scene.load.angle ? FORCE_BOTH : FORCE_NORMAL) : FORCE_NONE;
  in[PATCH_POSITION] = indenter.position;
  in[PATCH_MOST] = force ? path.most / scene.sensor.young : path.most;

  const Interval edges = std::visit(ShapeRows(lane), indenter.shape);
  const Interval rubber{-0.5 * scene.sensor.length - indenter.position, 0.5 * scene.sensor.length - indenter.position};
  Interval limits{std::max(edges.left, rubber.left), std::min(edges.right, rubber.right)};
  in[PATCH_LEFT_EDGE] = edges.left > rubber.left;
  in[PATCH_RIGHT_EDGE] = edges.right < rubber.right;
  if (limits.left >= limits.right) limits = {-1, 1};  // not over the rubber: heights are not finite there
  in[PATCH_LEFT] = limits.left;
  in[PATCH_RIGHT] = limits.right;
  Interval window = limits;
  if (!force) {
    const Interval inside =
        std::visit([&](const auto& shape) { return below(shape, lane, path.most); }, indenter.shape);
    window = {std::max(limits.left, inside.left), std::min(limits.right, inside.right)};
    if (window.left >= window.right || window.right - window.left < 1e-30) window = limits;  // nothing touches
  }
  if (given) window = {given->left, given->right};
  const fem::Interval lowest = fem::lowest_part({indenter.shape, 0});
  in[PATCH_GIVEN] = given.has_value();
  in[PATCH_FROM] = window.left;
  in[PATCH_TO] = window.right;
  in[PATCH_LOWEST_LEFT] = std::clamp(lowest.left, limits.left, limits.right);
  in[PATCH_LOWEST_RIGHT] = std::clamp(lowest.right, limits.left, limits.right);
  return lane;
}

}  // namespace tactel::host
