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
using ShapeNumbers = std::array<Number, 3>;

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

ShapeNumbers numbers(const fem::Sphere& s) { return {{{"radius", "mm", s.radius}}}; }
ShapeNumbers numbers(const fem::Paraboloid& s) {
  return {{{"radius_x", "mm", s.radii[0]}, {"radius_y", "mm", s.radii[1]}}};
}
ShapeNumbers numbers(const fem::LyingCylinder& s) {
  return {{{"radius", "mm", s.radius}, {"half_length", "mm", s.half_length}}};
}
ShapeNumbers numbers(const fem::Punch& s) { return {{{"radius", "mm", s.radius}, {"edge", "mm", s.edge}}}; }
ShapeNumbers numbers(const fem::Box& s) {
  return {{{"half_width_x", "mm", s.half_widths[0]}, {"half_width_y", "mm", s.half_widths[1]}, {"edge", "mm", s.edge}}};
}
ShapeNumbers numbers(const fem::Cone& s) { return {{{"angle", "degrees", s.angle}}}; }
ShapeNumbers numbers(const fem::HeightMap&) { return {}; }

template <class Shape>
ShapeNumbers shape_numbers(const Shape& shape) {
  return std::visit([](const auto& s) { return numbers(s); }, shape);
}

/// A number that any scene has.
template <class Of>
struct NumberOf {
  const char *key, *unit;
  double (*value)(const Of&);
};

constexpr std::array<NumberOf<fem::Sensor>, 7> sensor_numbers_of(const fem::Scene*) {
  return {{
      {"length", "mm", [](const fem::Sensor& s) { return s.length; }},
      {"thickness", "mm", [](const fem::Sensor& s) { return s.thickness; }},
      {"young", "MPa", [](const fem::Sensor& s) { return s.young; }},
      {"poisson", "1", [](const fem::Sensor& s) { return s.poisson; }},
      {"tactel_span", "mm", [](const fem::Sensor& s) { return s.span(); }},
      {"tactel_width", "mm", [](const fem::Sensor& s) { return s.tactel_width; }},
      {"grading", "1", [](const fem::Sensor& s) { return s.grading; }},
  }};
}
constexpr std::array<NumberOf<fem::PadSensor>, 3> sensor_numbers_of(const fem::PadScene*) {
  return {{
      {"thickness", "mm", [](const fem::PadSensor& s) { return s.thickness; }},
      {"young", "MPa", [](const fem::PadSensor& s) { return s.young; }},
      {"poisson", "1", [](const fem::PadSensor& s) { return s.poisson; }},
  }};
}
constexpr std::size_t numbers_of_own_sensors = 5;  // of a line, and where its tactels are; of a pad all

constexpr std::array<NumberOf<fem::Indenter>, 1> place_numbers_of(const fem::Scene*) {
  return {{{"position", "mm", [](const fem::Indenter& i) { return i.position; }}}};
}
constexpr std::array<NumberOf<fem::PadIndenter>, 5> place_numbers_of(const fem::PadScene*) {
  return {{
      {"position_x", "mm", [](const fem::PadIndenter& i) { return i.position[0]; }},
      {"position_y", "mm", [](const fem::PadIndenter& i) { return i.position[1]; }},
      {"yaw", "degrees", [](const fem::PadIndenter& i) { return i.yaw; }},
      {"tilt", "degrees", [](const fem::PadIndenter& i) { return i.tilt; }},
      {"tilt_direction", "degrees", [](const fem::PadIndenter& i) { return i.tilt_direction; }},
  }};
}

template <class Scene>
constexpr auto sensor_numbers = sensor_numbers_of(static_cast<const Scene*>(nullptr));
template <class Scene>
constexpr auto place_numbers = place_numbers_of(static_cast<const Scene*>(nullptr));

template <class Sensor>
bool differ(std::span<const Sensor> sensors, const NumberOf<Sensor>& number) {
  return std::ranges::any_of(sensors, [&](const Sensor& s) { return number.value(s) != number.value(sensors[0]); });
}

}  // namespace

template <class Scene>
std::size_t ContactParametersOf<Scene>::add(const std::string& name, const std::string& unit) {
  const auto there = std::ranges::find(columns_, name, &Column::name);
  if (there != columns_.end()) return static_cast<std::size_t>(there - columns_.begin());
  columns_.push_back({name, unit});
  return columns_.size() - 1;
}

template <class Scene>
ContactParametersOf<Scene>::ContactParametersOf(std::span<const Scene> scenes, std::span<const Sensor> sensors,
                                                bool own_sensors)
    : columns_{{"indenter", "place in the attribute indenter_names"}} {
  for (const auto& number : place_numbers<Scene>) add(std::string("indenter.") + number.key, number.unit);
  add("contact.friction", "1");
  std::set<int> powers;
  for (const Scene& scene : scenes) {
    const Shape& shape = scene.indenter.shape;
    const ShapeNumbers its = shape_numbers(shape);
    for (std::size_t k = 0; k < its.size(); ++k)
      if (its[k].key) of_shape_[shape.index()][k] = add(std::string("indenter.") + its[k].key, its[k].unit);
    if constexpr (std::is_same_v<Shape, fem::Shape>)
      if (const auto* taylor = std::get_if<fem::Taylor>(&shape))
        powers.insert(taylor->powers.begin(), taylor->powers.end());
  }
  powers_.assign(powers.begin(), powers.end());
  coefficients_ = columns_.size();
  for (const int power : powers_) add("indenter.coefficient_" + std::to_string(power), "1");
  sensor_ = columns_.size();
  for (std::size_t k = 0; k < sensor_numbers<Scene>.size(); ++k) {
    const auto& number = sensor_numbers<Scene>[k];
    if (!(own_sensors && k < numbers_of_own_sensors) && !differ(sensors, number)) continue;
    add(std::string("sensor.") + number.key, number.unit);
    sensor_numbers_.push_back(static_cast<int>(k));
  }
}

template <class Scene>
void ContactParametersOf<Scene>::put(const Scene& scene, std::uint16_t kind, std::span<float> row) const {
  std::ranges::fill(row, std::numeric_limits<float>::quiet_NaN());
  const auto put = [&](std::size_t column, double value) { row[column] = static_cast<float>(value); };
  std::size_t next = 0;
  put(next++, kind);
  for (const auto& number : place_numbers<Scene>) put(next++, number.value(scene.indenter));
  put(next, scene.friction);
  const Shape& shape = scene.indenter.shape;
  const ShapeNumbers its = shape_numbers(shape);
  for (std::size_t k = 0; k < its.size(); ++k)
    if (its[k].key) put(of_shape_[shape.index()][k], its[k].value);
  if constexpr (std::is_same_v<Shape, fem::Shape>)
    if (const auto* taylor = std::get_if<fem::Taylor>(&shape)) {
      std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(coefficients_), powers_.size(), 0.0f);
      for (std::size_t k = 0; k < taylor->powers.size(); ++k) {
        const auto power = std::ranges::lower_bound(powers_, taylor->powers[k]) - powers_.begin();
        row[coefficients_ + static_cast<std::size_t>(power)] +=
            static_cast<float>(taylor->coefficients.empty() ? 1 : taylor->coefficients[k]);
      }
    }
  for (std::size_t k = 0; k < sensor_numbers_.size(); ++k)
    put(sensor_ + k, sensor_numbers<Scene>[static_cast<std::size_t>(sensor_numbers_[k])].value(scene.sensor));
}

template class ContactParametersOf<fem::Scene>;
template class ContactParametersOf<fem::PadScene>;

}  // namespace tactel::host
