// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"

namespace tactel::host {

/// Numbers of contacts, for regressions: kind and place of the indenter, numbers of its shape, mu, and the numbers of
/// the sensor that differ between contacts. Scene: fem::Scene or fem::PadScene.
template <class Scene>
class ContactParametersOf {
  using Sensor = decltype(Scene::sensor);
  using Shape = std::remove_cvref_t<decltype(Scene{}.indenter.shape)>;

 public:
  struct Column {
    std::string name;  ///< as in a scene file: "indenter.radius"; "indenter" is the kind
    std::string unit;
  };
  /// `scenes`: one for each shape that contacts may have. `sensors`: all of them. `own_sensors`: every contact has its
  /// own length, thickness, Young's modulus and Poisson's ratio.
  ContactParametersOf(std::span<const Scene> scenes, std::span<const Sensor> sensors, bool own_sensors);

  const std::vector<Column>& columns() const { return columns_; }
  /// Writes the row of a contact, [columns]. NaN where its shape has no such number.
  void put(const Scene& scene, std::uint16_t kind, std::span<float> row) const;

 private:
  static constexpr std::size_t most_of_a_shape = 3;
  std::size_t add(const std::string& name, const std::string& unit);

  std::vector<Column> columns_;
  bool soft_ = false;  ///< some indenter of a pad is: all have columns for it
  /// [shapes] columns of the numbers of a shape, in their order
  std::array<std::array<std::size_t, most_of_a_shape>, std::variant_size_v<Shape>> of_shape_{};
  std::vector<int> powers_;           ///< of Taylor shapes, increasing
  std::size_t coefficients_ = 0;      ///< column of the first power
  std::size_t sensor_ = 0;            ///< column of the first number of the sensor
  std::vector<bool> sensor_numbers_;  ///< which of them have a column
};

using ContactParameters = ContactParametersOf<fem::Scene>;
extern template class ContactParametersOf<fem::Scene>;
extern template class ContactParametersOf<fem::PadScene>;

}  // namespace tactel::host
