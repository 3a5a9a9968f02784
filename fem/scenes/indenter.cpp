// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/indenter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "fem/scenes/measured_profile.h"
#include "fem/scenes/shape_numbers.h"

namespace tactel::fem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Heights at signed distance d from the indenter's position; all but the measured profile are even. mm
double height(const Flat& s, double d) {
  return !s.half_width || std::abs(d) <= *s.half_width + edge_guard ? 0 : infinity;
}
double height(const Wedge& s, double d) { return std::abs(d) / std::tan(s.edge_angle / 2 * std::numbers::pi / 180); }
double height(const Parabola& s, double d) { return d * d / (2 * s.radius); }
double height(const Cylinder& s, double d) {
  const double r = std::min(std::abs(d), s.radius);
  if (std::abs(d) > s.radius + edge_guard) return infinity;
  // radius - sqrt(radius^2 - r^2) without its cancellation near r = 0.
  return r * r / (s.radius + std::sqrt((s.radius - r) * (s.radius + r)));
}
double height(const Exponential& s, double d) { return s.height * std::expm1(s.rate * std::abs(d)); }
double height(const Trapezoid& s, double d) { return s.slope * std::max(0.0, std::abs(d) - s.half_width); }
double height(const RoundedFlat& s, double d) {
  const double beyond = std::max(0.0, std::abs(d) - s.half_width);
  return beyond * beyond / (2 * s.radius);
}
double height(const Taylor& s, double d) {
  double sum = 0;
  for (std::size_t i = 0; i < s.powers.size(); ++i)
    sum += (s.coefficients.empty() ? 1 : s.coefficients[i]) * std::pow(std::abs(d) / s.scale, s.powers[i]);
  return s.height.value_or(s.scale) * sum;
}
double height(const Profile& s, double d) { return height_between_points(s, d); }

/// Half the width of the flat bottom, mm.
Interval bottom(const Flat& s) {
  return s.half_width ? Interval{-*s.half_width, *s.half_width} : Interval{-infinity, infinity};
}
Interval bottom(const Trapezoid& s) { return {-s.half_width, s.half_width}; }
Interval bottom(const RoundedFlat& s) { return {-s.half_width, s.half_width}; }
Interval bottom(const Taylor& s) {
  const bool flat = std::ranges::all_of(s.coefficients, [](double c) { return c == 0; });
  return s.powers.empty() || (flat && !s.coefficients.empty()) ? Interval{-infinity, infinity} : Interval{0, 0};
}
Interval bottom(const Profile& s) {
  const Profile hull = convex_profile(s);
  Interval lowest{infinity, -infinity};
  for (std::size_t i = 0; i < hull.x.size(); ++i)
    if (hull.y[i] == 0) lowest = {std::min(lowest.left, hull.x[i]), std::max(lowest.right, hull.x[i])};
  return lowest;
}
template <class Pointed>
Interval bottom(const Pointed&) {
  return {0, 0};
}

void check_indenter(bool good, const char* member, double value, const char* allowed) {
  if (!good) throw ValueError(std::string("indenter.") + member, number_text(value), allowed);
}
/// Lengths beyond these bounds are slips of the pen, and overflow would follow.
bool length(double value) { return value >= 1e-6 && value <= 1e9; }
constexpr const char* length_text = "a length in mm, between 1e-6 and 1e9";

void check_shape(const Flat& s) {
  if (s.half_width) check_indenter(length(*s.half_width), "half_width", *s.half_width, length_text);
}
void check_shape(const Wedge& s) {
  check_indenter(s.edge_angle > 0 && s.edge_angle < 180, "edge_angle", s.edge_angle,
                 "the full angle in degrees, above 0 and below 180");
}
void check_shape(const Parabola& s) { check_indenter(length(s.radius), "radius", s.radius, length_text); }
void check_shape(const Cylinder& s) { check_indenter(length(s.radius), "radius", s.radius, length_text); }
void check_shape(const Exponential& s) {
  check_indenter(length(s.height), "height", s.height, length_text);
  check_indenter(s.rate >= 1e-6 && s.rate <= 1e6, "rate", s.rate, "a rate in 1/mm, between 1e-6 and 1e6");
}
void check_shape(const Trapezoid& s) {
  check_indenter(s.half_width == 0 || length(s.half_width), "half_width", s.half_width,
                 "0 or a length in mm, between 1e-6 and 1e9");
  check_indenter(s.slope >= 1e-9 && s.slope <= 1e9, "slope", s.slope,
                 "a slope (height over distance), between 1e-9 and 1e9");
}
void check_shape(const RoundedFlat& s) {
  check_indenter(s.half_width == 0 || length(s.half_width), "half_width", s.half_width,
                 "0 or a length in mm, between 1e-6 and 1e9");
  check_indenter(length(s.radius), "radius", s.radius, length_text);
}
void check_shape(const Taylor& s) {
  for (int k : s.powers) check_indenter(k >= 1 && k <= 100, "powers", k, "whole numbers from 1 to 100");
  check_indenter(length(s.scale), "scale", s.scale, length_text);
  if (s.height) check_indenter(length(*s.height), "height", *s.height, length_text);
  check_indenter(s.coefficients.empty() || s.coefficients.size() == s.powers.size(), "coefficients",
                 static_cast<double>(s.coefficients.size()), "as many as powers");
  for (double c : s.coefficients) check_indenter(c >= 0 && c <= 1e9, "coefficients", c, "numbers from 0 to 1e9");
}
void check_shape(const Profile& s) { fem::validate(s); }

}  // namespace

void validate(const Indenter& indenter) {
  check_indenter(std::abs(indenter.position) <= 1e6, "position", indenter.position,
                 "a position in mm, between -1e6 and 1e6");
  std::visit([](const auto& s) { check_shape(s); }, indenter.shape);
}

double profile_height(const Indenter& indenter, double x) {
  const auto at = [&](const auto& s) { return height(s, x - indenter.position); };
  const auto measured = std::get_if<Profile>(&indenter.shape);
  return measured ? at(convex_profile(*measured)) : std::visit(at, indenter.shape);
}

Eigen::VectorXd profile_heights(const Indenter& indenter, const Eigen::VectorXd& x) {
  const auto heights = [&](const auto& s) -> Eigen::VectorXd {
    return x.unaryExpr([&](double at) { return height(s, at - indenter.position); });
  };
  const auto measured = std::get_if<Profile>(&indenter.shape);
  return measured ? heights(convex_profile(*measured)) : std::visit(heights, indenter.shape);
}

Interval lowest_part(const Indenter& indenter) {
  const Interval local = std::visit([](const auto& s) { return bottom(s); }, indenter.shape);
  return {local.left + indenter.position, local.right + indenter.position};
}

const char* shape_name(const Shape& shape) {
  static_assert(line_shapes.size() == std::variant_size_v<Shape>);
  return line_shapes[shape.index()].key;
}

}  // namespace tactel::fem
