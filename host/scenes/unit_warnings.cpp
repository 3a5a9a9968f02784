// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/unit_warnings.h"

#include <fmt/format.h>

#include <Eigen/Dense>
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
    usual_radius{"indenter.radius", "mm", 0.05, longest}, usual_object{"indenter.young", "MPa", 0.001, 1000},
    usual_curvature{"sensor.curvature_radius", "mm", shortest, longest},
    usual_measured{"indenter's measured width", "mm", 0.1, 1000};

/// Heights that were measured, [along x][along y] mm, over a width along the longer side; of a line one column.
struct Measured {
  Eigen::MatrixXd heights;
  double width;
  double lowest_end = 0;  ///< mm: at the border, above the lowest of all
};

double lowest_border(const Eigen::MatrixXd& h) {
  const double ends = std::min(h.row(0).minCoeff(), h.bottomRows(1).minCoeff());
  const double sides = h.cols() > 1 ? std::min(h.col(0).minCoeff(), h.rightCols(1).minCoeff()) : ends;
  return std::min(ends, sides) - h.minCoeff();
}

std::optional<Measured> measured(const fem::Shape& shape) {
  const auto* profile = std::get_if<fem::Profile>(&shape);
  if (profile == nullptr || profile->file.empty() || profile->y.size() < 2) return std::nullopt;
  const Eigen::MatrixXd y =
      Eigen::Map<const Eigen::VectorXd>(profile->y.data(), static_cast<Eigen::Index>(profile->y.size()));
  return Measured{y, profile->x.back() - profile->x.front(), lowest_border(y)};
}

std::optional<Measured> measured(const fem::PadShape& shape) {
  const auto* map = std::get_if<fem::HeightMap>(&shape);
  if (map == nullptr || map->heights.size() < 4) return std::nullopt;
  return Measured{map->heights,
                  map->pitch * static_cast<double>(std::max(map->heights.rows(), map->heights.cols()) - 1),
                  lowest_border(map->heights)};
}

/// The point inside that stands out most: how far all of its neighbours are on one side of it, where the farthest
/// neighbours of half of all points are `usual` away. That is 1.8 times `usual` at most in white noise of 1e6 points,
/// and 0.7 times at a cone's tip.
struct Alone {
  Eigen::Index i = 0, j = 0;
  double distance = 0, usual = 0;  ///< mm
};

Alone most_alone(const Eigen::MatrixXd& h) {
  std::vector<double> farthest;
  Alone most;
  const Eigen::Index side = h.cols() > 2 ? 1 : 0;  // of a line all points are inside
  for (Eigen::Index j = side; j < h.cols() - side; ++j)
    for (Eigen::Index i = 1; i < h.rows() - 1; ++i) {
      Eigen::ArrayXXd beside = h.block(i - 1, j - side, 3, 1 + 2 * side).array() - h(i, j);
      farthest.push_back(beside.abs().maxCoeff());
      beside(1, side) = beside(0, 0);  // the point itself
      const double distance = std::max(beside.minCoeff(), -beside.maxCoeff());
      if (distance > most.distance) most = {i, j, distance};
    }
  if (farthest.empty()) return most;
  const auto middle = farthest.begin() + static_cast<std::ptrdiff_t>(farthest.size() / 2);
  std::ranges::nth_element(farthest, middle);
  most.usual = *middle;
  return most;
}

/// The deepest indentation that the load asks for, mm; 0 where it is by force.
template <class Load>
double depth_of(const Load& load) {
  return load.indentation.empty() || !load.normal_force.empty() ? 0 : std::ranges::max(load.indentation);
}

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

/// Numbers that pads alone have.
struct PadNumbers {
  std::optional<double> width{}, young_of_object{}, curvature{};
};
PadNumbers pad_numbers(const fem::Scene&) { return {}; }
PadNumbers pad_numbers(const fem::PadScene& scene) {
  return {scene.sensor.width, scene.indenter.young, scene.sensor.curvature_radius};
}

constexpr std::uint64_t most_looked_at = 100;  ///< contacts of a sweep

/// Warns of each number once.
class UnitWarnings {
 public:
  template <class Scene>
  void look_at(const Scene& scene, const std::string& place = "") {
    look(usual_young, scene.sensor.young, place);
    look(usual_thickness, scene.sensor.thickness, place);
    look(usual_length, scene.sensor.length, place);
    const PadNumbers of_pad = pad_numbers(scene);
    look(usual_width, of_pad.width, place);
    look(usual_radius, radius_of(scene.indenter.shape), place);
    look(usual_object, of_pad.young_of_object, place);
    look(usual_curvature, of_pad.curvature, place);
    look(measured(scene.indenter.shape), depth_of(scene.load), place);
  }
  std::vector<std::string> take() { return std::move(all_); }

 private:
  void look(const UsualRange& usual, std::optional<double> value, const std::string& place) {
    if (!value || (*value >= usual.low && *value <= usual.high) || !seen_.insert(usual.key).second) return;
    all_.push_back(fmt::format("{}{} = {:g} {}: usual are {:g} to {:g} {}; check the unit", place, usual.key, *value,
                               usual.unit, usual.low, usual.high, usual.unit));
  }
  void look(const std::optional<Measured>& shape, double depth, const std::string& place) {
    if (!shape || !seen_.insert(fmt::format("{} {}", shape->width, shape->heights.sum())).second) return;
    look(usual_measured, shape->width, place);
    const double range = shape->heights.maxCoeff() - shape->heights.minCoeff();
    if (range > shape->width && seen_.insert("range").second)
      all_.push_back(
          fmt::format("{}the indenter's measured heights span {:g} mm over a width of {:g} mm; check the unit", place,
                      range, shape->width));
    if (shape->lowest_end <= depth && seen_.insert("border").second)
      all_.push_back(place +
                     "the indenter touches at the border of its measured heights, where it ends: measure farther out; "
                     "heights that are upside down do so, too (they count upwards from the lowest point)");
    const Alone alone = most_alone(shape->heights);
    if (alone.usual > 0 && alone.distance > 6 * alone.usual && seen_.insert("alone").second)
      all_.push_back(
          fmt::format("{}the indenter's measured height {}{} is {:g} mm from all its neighbours, where others are {:g} "
                      "mm apart; if it "
                      "is a fault of the measurement, fill it from its neighbours",
                      place, alone.i + 1, shape->heights.cols() > 1 ? fmt::format(" of line {}", alone.j + 1) : "",
                      alone.distance, alone.usual));
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
      [&](const auto& sweep) {
        auto scene = typename std::remove_cvref_t<decltype(sweep)>::Contact{}.scene;
        for (const auto& sensor : sweep.sensors()) scene.sensor = sensor, warnings.look_at(scene);
        for (std::uint64_t k = 0; k < std::min(sweep.contacts(), most_looked_at); ++k)
          warnings.look_at(sweep.contact(k).scene);
      },
      source);
  return warnings.take();
}

}  // namespace tactel::host
