// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/contact_parameters.h"

#include <algorithm>
#include <limits>
#include <set>

namespace tactel::host {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

struct Number {
  const char* key = nullptr;
  const char* unit = "";
  double value = none;
};
using ShapeNumbers = std::array<Number, 2>;

// The numbers of a shape but for the coefficients of a Taylor shape. Their keys depend on the type alone.
ShapeNumbers numbers(const fem::Flat& s) { return {{{"half_width", "mm", s.half_width.value_or(none)}}}; }
ShapeNumbers numbers(const fem::Wedge& s) { return {{{"edge_angle", "degrees", s.edge_angle}}}; }
ShapeNumbers numbers(const fem::Parabola& s) { return {{{"radius", "mm", s.radius}}}; }
ShapeNumbers numbers(const fem::Cylinder& s) { return {{{"radius", "mm", s.radius}}}; }
ShapeNumbers numbers(const fem::Exponential& s) { return {{{"height", "mm", s.height}, {"rate", "1/mm", s.rate}}}; }
ShapeNumbers numbers(const fem::Trapezoid& s) {
  return {{{"half_width", "mm", s.half_width}, {"slope", "1", s.slope}}};
}
ShapeNumbers numbers(const fem::RoundedFlat& s) {
  return {{{"half_width", "mm", s.half_width}, {"radius", "mm", s.radius}}};
}
ShapeNumbers numbers(const fem::Taylor& s) {
  return {{{"scale", "mm", s.scale}, {"height", "mm", s.height.value_or(s.scale)}}};
}
ShapeNumbers numbers(const fem::Profile& s) {
  if (s.x.empty() || s.y.empty()) return {{{"half_width", "mm"}, {"height", "mm"}}};
  const auto [least, most] = std::ranges::minmax(s.y);
  return {{{"half_width", "mm", 0.5 * (s.x.back() - s.x.front())}, {"height", "mm", most - least}}};
}

ShapeNumbers shape_numbers(const fem::Shape& shape) {
  return std::visit([](const auto& s) { return numbers(s); }, shape);
}

struct SensorNumber {
  const char *key, *unit;
  double (*value)(const fem::Sensor&);
};
constexpr std::array<SensorNumber, 7> sensor_numbers = {{
    {"length", "mm", [](const fem::Sensor& s) { return s.length; }},
    {"thickness", "mm", [](const fem::Sensor& s) { return s.thickness; }},
    {"young", "MPa", [](const fem::Sensor& s) { return s.young; }},
    {"poisson", "1", [](const fem::Sensor& s) { return s.poisson; }},
    {"tactel_span", "mm", [](const fem::Sensor& s) { return s.span(); }},
    {"tactel_width", "mm", [](const fem::Sensor& s) { return s.tactel_width; }},
    {"grading", "1", [](const fem::Sensor& s) { return s.grading; }},
}};
constexpr int numbers_of_own_sensors = 5;  // and where its tactels are

bool differ(std::span<const fem::Sensor> sensors, const SensorNumber& number) {
  return std::ranges::any_of(sensors,
                             [&](const fem::Sensor& s) { return number.value(s) != number.value(sensors[0]); });
}

}  // namespace

std::size_t ContactParameters::add(const std::string& name, const std::string& unit) {
  const auto there = std::ranges::find(columns_, name, &Column::name);
  if (there != columns_.end()) return static_cast<std::size_t>(there - columns_.begin());
  columns_.push_back({name, unit});
  return columns_.size() - 1;
}

ContactParameters::ContactParameters(std::span<const fem::Scene> scenes, std::span<const fem::Sensor> sensors,
                                     bool own_sensors)
    : columns_{{"indenter", "place in the attribute indenter_names"},
               {"indenter.position", "mm"},
               {"contact.friction", "1"}} {
  std::set<int> powers;
  for (const fem::Scene& scene : scenes) {
    const fem::Shape& shape = scene.indenter.shape;
    const ShapeNumbers its = shape_numbers(shape);
    for (std::size_t k = 0; k < its.size(); ++k)
      if (its[k].key) of_shape_[shape.index()][k] = add(std::string("indenter.") + its[k].key, its[k].unit);
    if (const auto* taylor = std::get_if<fem::Taylor>(&shape))
      powers.insert(taylor->powers.begin(), taylor->powers.end());
  }
  powers_.assign(powers.begin(), powers.end());
  coefficients_ = columns_.size();
  for (const int power : powers_) add("indenter.coefficient_" + std::to_string(power), "1");
  sensor_ = columns_.size();
  for (int k = 0; k < static_cast<int>(sensor_numbers.size()); ++k) {
    if (!(own_sensors && k < numbers_of_own_sensors) && !differ(sensors, sensor_numbers[k])) continue;
    add(std::string("sensor.") + sensor_numbers[k].key, sensor_numbers[k].unit);
    sensor_numbers_.push_back(k);
  }
}

void ContactParameters::put(const fem::Scene& scene, std::uint16_t kind, std::span<float> row) const {
  std::ranges::fill(row, std::numeric_limits<float>::quiet_NaN());
  const auto put = [&](std::size_t column, double value) { row[column] = static_cast<float>(value); };
  put(0, kind), put(1, scene.indenter.position), put(2, scene.friction);
  const fem::Shape& shape = scene.indenter.shape;
  const ShapeNumbers its = shape_numbers(shape);
  for (std::size_t k = 0; k < its.size(); ++k)
    if (its[k].key) put(of_shape_[shape.index()][k], its[k].value);
  if (const auto* taylor = std::get_if<fem::Taylor>(&shape)) {
    std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(coefficients_), powers_.size(), 0.0f);
    for (std::size_t k = 0; k < taylor->powers.size(); ++k) {
      const auto power = std::ranges::lower_bound(powers_, taylor->powers[k]) - powers_.begin();
      row[coefficients_ + static_cast<std::size_t>(power)] +=
          static_cast<float>(taylor->coefficients.empty() ? 1 : taylor->coefficients[k]);
    }
  }
  for (std::size_t k = 0; k < sensor_numbers_.size(); ++k)
    put(sensor_ + k, sensor_numbers[static_cast<std::size_t>(sensor_numbers_[k])].value(scene.sensor));
}

}  // namespace tactel::host
