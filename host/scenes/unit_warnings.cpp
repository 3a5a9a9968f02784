// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/unit_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

namespace tactel::host {
namespace {

/// A number with the range in which rubber skins and their indenters lie; beyond it the unit is doubtful. 100 MPa is
/// ten times the hardest rubber's; a meter in mm, a millimeter in m and in um lie outside of every range.
struct UsualRange {
  const char *key, *unit;
  double low, high;
};
constexpr double shortest = 0.5, longest = 5000;
constexpr UsualRange usual_young{"sensor.young", "MPa", 0.01, 100}, usual_thickness{"sensor.thickness", "mm", 0.05, 50},
    usual_length{"sensor.length", "mm", shortest, longest}, usual_width{"sensor.width", "mm", shortest, longest},
    usual_radius{"indenter.radius", "mm", 0.05, longest};

/// The radius of a shape that has one.
template <class Shapes>
std::optional<double> radius_of(const Shapes& shape) {
  return std::visit(
      [](const auto& s) -> std::optional<double> {
        if constexpr (requires { s.radius; }) return s.radius;
        return std::nullopt;
      },
      shape);
}

constexpr std::uint64_t most_looked_at = 100;  ///< contacts of a sweep

/// Warns of each number once.
class UnitWarnings {
 public:
  void look_at(const fem::Scene& scene, const std::string& place = "") {
    look(usual_young, scene.sensor.young, place);
    look(usual_thickness, scene.sensor.thickness, place);
    look(usual_length, scene.sensor.length, place);
    look(usual_radius, radius_of(scene.indenter.shape), place);
  }
  void look_at(const fem::PadScene& scene, const std::string& place = "") {
    look(usual_young, scene.sensor.young, place);
    look(usual_thickness, scene.sensor.thickness, place);
    look(usual_length, scene.sensor.length, place);
    look(usual_width, scene.sensor.width, place);
    look(usual_radius, radius_of(scene.indenter.shape), place);
  }
  std::vector<std::string> take() { return std::move(all_); }

 private:
  void look(const UsualRange& usual, std::optional<double> value, const std::string& place) {
    if (!value || (*value >= usual.low && *value <= usual.high) || !seen_.insert(usual.key).second) return;
    all_.push_back(fmt::format("{}{} = {:g} {}: usual are {:g} to {:g} {}; check the unit", place, usual.key, *value,
                               usual.unit, usual.low, usual.high, usual.unit));
  }
  std::set<std::string> seen_;
  std::vector<std::string> all_;
};

}  // namespace

std::vector<std::string> unit_warnings(const fem::Scene& scene) {
  UnitWarnings warnings;
  warnings.look_at(scene);
  return warnings.take();
}

std::vector<std::string> unit_warnings(const fem::PadScene& scene) {
  UnitWarnings warnings;
  warnings.look_at(scene);
  return warnings.take();
}

template <class Scene>
std::vector<std::string> unit_warnings_of_many(std::span<const Scene> scenes) {
  UnitWarnings warnings;
  for (std::size_t i = 0; i < scenes.size(); ++i) warnings.look_at(scenes[i], fmt::format("scenes[{}]: ", i));
  return warnings.take();
}

std::vector<std::string> unit_warnings(std::span<const fem::Scene> scenes) { return unit_warnings_of_many(scenes); }
std::vector<std::string> unit_warnings(std::span<const fem::PadScene> scenes) { return unit_warnings_of_many(scenes); }

std::vector<std::string> unit_warnings(const AnySource& source) {
  UnitWarnings warnings;
  std::visit(
      [&](const auto& of) {
        auto scene = typename std::remove_cvref_t<decltype(of)>::Contact{}.scene;
        for (const auto& sensor : of.sensors()) scene.sensor = sensor, warnings.look_at(scene);
        for (std::uint64_t k = 0; k < std::min(of.contacts(), most_looked_at); ++k)
          warnings.look_at(of.contact(k).scene);
      },
      source);
  return warnings.take();
}

}  // namespace tactel::host
