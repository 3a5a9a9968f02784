// SPDX-License-Identifier: Apache-2.0
#include "fem/shape_derivatives.h"

#include <cmath>
#include <functional>
#include <numbers>

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

}  // namespace tactel::fem
