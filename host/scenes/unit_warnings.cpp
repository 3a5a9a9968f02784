// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/unit_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace tactel::host {
namespace {

/// A number of a scene with the range in which rubber skins and their indenters lie; beyond it the unit is doubtful.
struct UsualRange {
  const char *key, *unit;
  double low, high;
  double (*value)(const fem::Scene&);  ///< `low` where the scene has no such number
};

constexpr double lowest_radius = 0.05;

double radius_of(const fem::Scene& scene) {
  return std::visit(
      [](const auto& shape) {
        if constexpr (requires { shape.radius; }) return shape.radius;
        return lowest_radius;
      },
      scene.indenter.shape);
}

// 100 MPa is ten times the hardest rubber's; a meter in mm, a millimeter in m and in um lie outside of every range.
constexpr UsualRange usual_ranges[] = {
    {"sensor.young", "MPa", 0.01, 100, [](const fem::Scene& s) { return s.sensor.young; }},
    {"sensor.thickness", "mm", 0.05, 50, [](const fem::Scene& s) { return s.sensor.thickness; }},
    {"sensor.length", "mm", 0.5, 5000, [](const fem::Scene& s) { return s.sensor.length; }},
    {"indenter.radius", "mm", lowest_radius, 5000, radius_of}};

constexpr std::uint64_t most_looked_at = 100;  ///< contacts of a sweep

/// Warns of each number once.
class UnitWarnings {
 public:
  void look_at(const fem::Scene& scene, const std::string& place = "") {
    for (const UsualRange& usual : usual_ranges) {
      const double value = usual.value(scene);
      if ((value >= usual.low && value <= usual.high) || !seen_.insert(usual.key).second) continue;
      all_.push_back(fmt::format("{}{} = {:g} {}: usual are {:g} to {:g} {}; check the unit", place, usual.key, value,
                                 usual.unit, usual.low, usual.high, usual.unit));
    }
  }
  std::vector<std::string> take() { return std::move(all_); }

 private:
  std::set<std::string> seen_;
  std::vector<std::string> all_;
};

}  // namespace

std::vector<std::string> unit_warnings(const fem::Scene& scene) {
  UnitWarnings warnings;
  warnings.look_at(scene);
  return warnings.take();
}

std::vector<std::string> unit_warnings(std::span<const fem::Scene> scenes) {
  UnitWarnings warnings;
  for (std::size_t i = 0; i < scenes.size(); ++i) warnings.look_at(scenes[i], fmt::format("scenes[{}]: ", i));
  return warnings.take();
}

std::vector<std::string> unit_warnings(const SceneSource& source) {
  UnitWarnings warnings;
  fem::Scene scene;
  for (const fem::Sensor& sensor : source.sensors()) scene.sensor = sensor, warnings.look_at(scene);
  for (std::uint64_t k = 0; k < std::min(source.contacts(), most_looked_at); ++k)
    warnings.look_at(source.contact(k).scene);
  return warnings.take();
}

}  // namespace tactel::host
