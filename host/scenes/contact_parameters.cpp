// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/contact_parameters.h"

#include <algorithm>
#include <limits>
#include <set>
#include <string_view>

#include "fem/scenes/scene_numbers.h"

namespace tactel::host {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

// Columns of a number: of a pair "_x" and "_y", of a list none.
void columns_of(const auto& number, double value, const auto& use) { use(number.key, "", number.unit, value); }
void columns_of(const auto& number, const std::optional<double>& value, const auto& use) {
  use(number.key, "", number.unit, value.value_or(none));
}
void columns_of(const auto& number, const std::array<double, 2>& value, const auto& use) {
  use(number.each, "_x", number.unit, value[0]), use(number.each, "_y", number.unit, value[1]);
}
template <class Value>
void columns_of(const auto&, const Value&, const auto&) {}

/// Calls use(key, axis, unit, value) for the columns of a struct: what sweeps draw.
template <class T, class Use>
void each_column(const T& from, const Use& use) {
  fem::each_number<T>([&](const auto& number) {
    if (number.drawn) columns_of(number, from.*number.member, use);
  });
}

bool is_soft(const fem::Scene&) { return false; }
bool is_soft(const fem::PadScene& scene) { return scene.indenter.young.has_value(); }

const fem::Taylor* taylor_of(const fem::Shape& shape) { return std::get_if<fem::Taylor>(&shape); }
const fem::Taylor* taylor_of(const fem::PadShape&) { return nullptr; }

/// Those of an indenter; of soft ones where some are.
template <class Indenter, class Use>
void indenter_columns(const Indenter& indenter, bool soft, const Use& use) {
  each_column(indenter, [&](std::string_view key, auto... others) {
    if (soft || (key != "young" && key != "poisson")) use(key.data(), others...);
  });
}

/// The columns of a shape but for the coefficients of a Taylor shape. Their keys depend on the type alone.
template <class S, class Use>
void shape_columns(const S& shape, const Use& use) {
  each_column(shape, use);
}
template <class Use>
void shape_columns(const fem::Taylor& shape, const Use& use) {
  each_column(fem::with_height(shape), use);
}
template <class Use>
void shape_columns(const fem::Profile& shape, const Use& use) {
  const bool points = !shape.x.empty() && !shape.y.empty();
  const auto [least, most] = points ? std::ranges::minmax(shape.y) : std::ranges::minmax_result<double>{none, none};
  use("half_width", "", "mm", points ? 0.5 * (shape.x.back() - shape.x.front()) : none);
  use("height", "", "mm", most - least);
}

template <class Use>
void sensor_columns(const fem::Sensor& sensor, const Use& use) {
  each_column(fem::with_span(sensor), use);
}
template <class Use>
void sensor_columns(const fem::PadSensor& sensor, const Use& use) {
  each_column(sensor, use);
}

/// Numbers of a line that differ between sensors of one array alone: contacts never draw their own.
bool of_the_array(std::string_view key) { return key == "grading" || key == "tactel_width"; }

/// [columns] the sensor's numbers.
template <class Sensor>
std::vector<double> sensor_values(const Sensor& sensor) {
  std::vector<double> values;
  sensor_columns(sensor, [&](auto, auto, auto, double value) { values.push_back(value); });
  return values;
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
  const auto add_to = [this](const std::string& table) {
    return [this, table](const char* key, const char* axis, const char* unit, double) {
      return add(table + key + axis, unit);
    };
  };
  soft_ = std::ranges::any_of(scenes, [](const Scene& scene) { return is_soft(scene); });
  indenter_columns(scenes[0].indenter, soft_, add_to("indenter."));
  add("contact.friction", "1");
  std::set<int> powers;
  for (const Scene& scene : scenes) {
    const Shape& shape = scene.indenter.shape;
    std::size_t k = 0;
    const auto put = [&, add_column = add_to("indenter.")](auto... column) {
      of_shape_[shape.index()][k++] = add_column(column...);
    };
    std::visit([&](const auto& s) { shape_columns(s, put); }, shape);
    if (const fem::Taylor* taylor = taylor_of(shape)) powers.insert(taylor->powers.begin(), taylor->powers.end());
  }
  powers_.assign(powers.begin(), powers.end());
  coefficients_ = columns_.size();
  for (const int power : powers_) add("indenter.coefficient_" + std::to_string(power), "1");
  sensor_ = columns_.size();
  std::vector<std::vector<double>> values;
  for (const Sensor& sensor : sensors) values.push_back(sensor_values(sensor));
  sensor_columns(sensors[0], [&](const char* key, const char* axis, const char* unit, double first) {
    const std::size_t k = sensor_numbers_.size();
    const bool differs = std::ranges::any_of(values, [&](const auto& numbers) { return numbers[k] != first; });
    sensor_numbers_.push_back(differs || (own_sensors && !of_the_array(key)));
    if (sensor_numbers_.back()) add(std::string("sensor.") + key + axis, unit);
  });
}

template <class Scene>
void ContactParametersOf<Scene>::put(const Scene& scene, std::uint16_t kind, std::span<float> row) const {
  std::ranges::fill(row, std::numeric_limits<float>::quiet_NaN());
  const auto put = [&](std::size_t column, double value) { row[column] = static_cast<float>(value); };
  std::size_t next = 0;
  put(next++, kind);
  indenter_columns(scene.indenter, soft_, [&](auto, auto, auto, double value) { put(next++, value); });
  put(next, scene.friction);
  const Shape& shape = scene.indenter.shape;
  const auto* column = of_shape_[shape.index()].data();
  std::visit([&](const auto& s) { shape_columns(s, [&](auto, auto, auto, double value) { put(*column++, value); }); },
             shape);
  if (const fem::Taylor* taylor = taylor_of(shape)) {
    std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(coefficients_), powers_.size(), 0.0f);
    for (std::size_t k = 0; k < taylor->powers.size(); ++k) {
      const auto power = std::ranges::lower_bound(powers_, taylor->powers[k]) - powers_.begin();
      row[coefficients_ + static_cast<std::size_t>(power)] +=
          static_cast<float>(taylor->coefficients.empty() ? 1 : taylor->coefficients[k]);
    }
  }
  std::size_t sensor_column = sensor_, k = 0;
  sensor_columns(scene.sensor, [&](auto, auto, auto, double value) {
    if (sensor_numbers_[k++]) put(sensor_column++, value);
  });
}

template class ContactParametersOf<fem::Scene>;
template class ContactParametersOf<fem::PadScene>;

}  // namespace tactel::host
