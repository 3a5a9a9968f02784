// SPDX-License-Identifier: Apache-2.0
#include "fem/shape_derivatives.h"

#include <cmath>
#include <functional>
#include <numbers>

#include "fem/measured_profile.h"

namespace tactel::fem {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// One number of a shape and dy/d(number) at distance r >= 0.
struct Number {
  std::string key;
  double value;
  const char* unit;
  std::function<double(double r)> height;
};

double tan_half(const Wedge& s) { return std::tan(s.edge_angle / 2 * degree); }
double beyond(double r, double half_width) { return std::max(0.0, r - half_width); }
double coefficient(const Taylor& s, std::size_t i) { return s.coefficients.empty() ? 1 : s.coefficients[i]; }

std::vector<Number> numbers(const Flat&) { return {}; }
std::vector<Number> numbers(const Profile&) { return {}; }
std::vector<Number> numbers(const Wedge& s) {
  const double half_sine = std::sin(s.edge_angle / 2 * degree);
  return {{"edge_angle", s.edge_angle, "degree", [=](double r) { return -r * degree / (2 * half_sine * half_sine); }}};
}
std::vector<Number> numbers(const Parabola& s) {
  return {{"radius", s.radius, "mm", [=](double r) { return -r * r / (2 * s.radius * s.radius); }}};
}
std::vector<Number> numbers(const Cylinder& s) {
  return {
      {"radius", s.radius, "mm", [=](double r) { return 1 - s.radius / std::sqrt((s.radius - r) * (s.radius + r)); }}};
}
std::vector<Number> numbers(const Exponential& s) {
  return {{"height", s.height, "mm", [=](double r) { return std::expm1(s.rate * r); }},
          {"rate", s.rate, "1/mm", [=](double r) { return s.height * r * std::exp(s.rate * r); }}};
}
std::vector<Number> numbers(const Trapezoid& s) {
  return {{"half_width", s.half_width, "mm", [=](double r) { return r > s.half_width ? -s.slope : 0; }},
          {"slope", s.slope, "", [=](double r) { return beyond(r, s.half_width); }}};
}
std::vector<Number> numbers(const RoundedFlat& s) {
  return {{"half_width", s.half_width, "mm", [=](double r) { return -beyond(r, s.half_width) / s.radius; }},
          {"radius", s.radius, "mm", [=](double r) {
             const double b = beyond(r, s.half_width) / s.radius;
             return -b * b / 2;
           }}};
}
std::vector<Number> numbers(const Taylor& s) {
  const auto sum = [s](double r, const auto& factor) {
    double sum = 0;
    for (std::size_t i = 0; i < s.powers.size(); ++i)
      sum += coefficient(s, i) * std::pow(r / s.scale, s.powers[i]) * factor(s.powers[i]);
    return sum;
  };
  // Where no height is given it is the scale.
  const double height = s.height.value_or(s.scale), own = s.height ? 0 : 1;
  std::vector<Number> all = {{"scale", s.scale, "mm", [=](double r) {
                                return sum(r, [&](int power) { return own - height * power / s.scale; });
                              }}};
  if (s.height) all.push_back({"height", *s.height, "mm", [=](double r) { return sum(r, [](int) { return 1.0; }); }});
  for (std::size_t i = 0; i < s.coefficients.size(); ++i)
    all.push_back({"coefficients[" + std::to_string(i) + "]", s.coefficients[i], "",
                   [=](double r) { return height * std::pow(r / s.scale, s.powers[i]); }});
  return all;
}

/// dy/dr at distance r > 0.
double slope(const Flat&, double) { return 0; }
double slope(const Wedge& s, double) { return 1 / tan_half(s); }
double slope(const Parabola& s, double r) { return r / s.radius; }
double slope(const Cylinder& s, double r) { return r / std::sqrt((s.radius - r) * (s.radius + r)); }
double slope(const Exponential& s, double r) { return s.height * s.rate * std::exp(s.rate * r); }
double slope(const Trapezoid& s, double r) { return r > s.half_width ? s.slope : 0; }
double slope(const RoundedFlat& s, double r) { return beyond(r, s.half_width) / s.radius; }
double slope(const Taylor& s, double r) {
  double sum = 0;
  for (std::size_t i = 0; i < s.powers.size(); ++i)
    sum += coefficient(s, i) * s.powers[i] * std::pow(r / s.scale, s.powers[i] - 1) / s.scale;
  return s.height.value_or(s.scale) * sum;
}

/// dy/dx of a measured profile at signed distance d from its position: the segment's, and the mean of both at a corner.
double measured_slope(const Profile& hull, double d) {
  for (std::size_t i = 1; i < hull.x.size(); ++i) {
    const double here = (hull.y[i] - hull.y[i - 1]) / (hull.x[i] - hull.x[i - 1]);
    if (d < hull.x[i - 1]) return 0;
    if (d < hull.x[i]) return here;
    if (d == hull.x[i])
      return i + 1 < hull.x.size() ? (here + (hull.y[i + 1] - hull.y[i]) / (hull.x[i + 1] - hull.x[i])) / 2 : here;
  }
  return 0;
}

}  // namespace

std::vector<HeightDerivative> height_derivatives(const Indenter& indenter, const Eigen::VectorXd& x) {
  const Eigen::VectorXd height = profile_heights(indenter, x);
  std::vector<HeightDerivative> all;
  for (const Number& number : std::visit([](const auto& s) { return numbers(s); }, indenter.shape)) {
    Eigen::VectorXd by(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i)
      by[i] = std::isfinite(height[i]) ? number.height(std::abs(x[i] - indenter.position)) : 0;
    all.push_back({number.key, number.value, number.unit, by});
  }
  return all;
}

Eigen::VectorXd profile_slopes(const Indenter& indenter, const Eigen::VectorXd& x) {
  const Eigen::VectorXd height = profile_heights(indenter, x);
  const auto slopes = [&](const auto& at) {
    Eigen::VectorXd result(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) result[i] = std::isfinite(height[i]) ? at(x[i] - indenter.position) : 0;
    return result;
  };
  if (const auto measured = std::get_if<Profile>(&indenter.shape)) {
    const Profile hull = convex_profile(*measured);
    return slopes([&](double d) { return measured_slope(hull, d); });
  }
  return slopes([&](double d) {
    if (d == 0) return 0.0;
    const auto at = [&](const auto& s) -> double {
      if constexpr (std::is_same_v<std::decay_t<decltype(s)>, Profile>)
        return 0;
      else
        return slope(s, std::abs(d));
    };
    return std::copysign(std::visit(at, indenter.shape), d);
  });
}

}  // namespace tactel::fem
