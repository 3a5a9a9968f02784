// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/numbers/angles.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_markers.h"
#include "fem/scenes/rubber.h"

namespace tactel::fem {
namespace {

constexpr const char *allowed_young = "a Young's modulus in MPa, 1e-9 to 1e12",
                     *allowed_poisson = "a Poisson's ratio, 0 <= poisson <= 0.5";

}  // namespace

const char* name(Sides sides) { return sides == Sides::free ? "free" : "held"; }

void check_length(const char* member, double value, const char* allowed) {
  require(value >= 1e-6 && value <= 1e6, member, value, allowed);
}

namespace {

void check_relaxation(const std::vector<std::array<double, 2>>& terms) {
  const char* key = "sensor.relaxation";
  require(terms.size() <= 4, key, static_cast<double>(terms.size()), "4 pairs [share, seconds] at most");
  double sum = 0;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const auto [share, time] = terms[k];
    require(share > 0 && share < 1, key, share, "shares of E above 0 and below 1");
    require(time >= 1e-9 && time <= 1e9, key, time, "times in s, 1e-9 to 1e9");
    for (std::size_t other = 0; other < k; ++other)
      require(std::abs(time - terms[other][1]) > 1e-6 * time, key, time,
              "times that differ; add the shares of equal ones");
    sum += share;
  }
  require(sum < 0.999, key, sum, "shares of E whose sum is below 0.999");
}

}  // namespace

void validate(const PadSensor& sensor) {
  check_layers(sensor.layers, sensor.thickness, sensor.young, sensor.poisson);
  check_relaxation(sensor.relaxation);
  check_length("sensor.thickness", sensor.thickness);
  require(sensor.young >= 1e-9 && sensor.young <= 1e12, "sensor.young", sensor.young, allowed_young);
  require(sensor.poisson >= 0 && sensor.poisson <= 0.5, "sensor.poisson", sensor.poisson, allowed_poisson);
  for (const int count : sensor.tactels)
    require(count >= 1 && count <= 100, "sensor.tactels", count, "numbers of tactels along x and y, 1 to 100 each");
  for (const double p : sensor.pitch) check_length("sensor.pitch", p);
  require(sensor.tactel_size >= 0 && sensor.tactel_size <= std::min(sensor.pitch[0], sensor.pitch[1]),
          "sensor.tactel_size", sensor.tactel_size, "a side in mm, 0 (a point) to the pitch");
  require(sensor.axes == 1 || sensor.axes == 3, "sensor.axes", sensor.axes, "3, or 1 (normal stress only)");
  const auto check_side = [&](const char* member, const std::optional<double>& side, int axis) {
    if (!side) return;
    check_length(member, *side);
    const double array = std::round(1e6 * ((sensor.tactels[axis] - 1) * sensor.pitch[axis] + sensor.tactel_size)) / 1e6;
    require(*side >= array, member, *side,
            ("a length in mm that holds the tactels, " + number_text(array) + " or more").c_str());
  };
  check_side("sensor.length", sensor.length, 0);
  check_side("sensor.width", sensor.width, 1);
  require(sensor.depth >= 0 && sensor.depth <= 0.75 * sensor.thickness, "sensor.depth", sensor.depth,
          "mm above the base, 0 to three quarters of sensor.thickness");
  const bool free = sensor.sides == Sides::free && sensor.length && sensor.width;
  require(!(free && sensor.depth > 0), "sensor.depth", sensor.depth,
          "0 where sides are free; or sensor.sides = \"held\"");
  if (const auto radius = sensor.curvature_radius) {
    check_length("sensor.curvature_radius", *radius);
    require(*radius >= 5 * sensor.thickness, "sensor.curvature_radius", *radius,
            "5 thicknesses or more: a flat layer, which stands for the curved one, is off by a seventh there");
    require(!free, "sensor.curvature_radius", *radius, "left out where sides are free; or sensor.sides = \"held\"");
  }
  if (free && !sensor.layers.empty())
    throw ValueError("sensor.layers", std::to_string(sensor.layers.size()) + " layers",
                     "left out where sides are free; or sensor.sides = \"held\"");
  constexpr double tallest = 4;
  if (free)
    require(sensor.thickness <= tallest * std::min(*sensor.length, *sensor.width), "sensor.thickness", sensor.thickness,
            "4 times the shorter side or less where sides are free; or sensor.sides = \"held\"");
}

double fall_of_skin(const PadSensor& sensor, double x, double y) {
  return sensor.curvature_radius ? (x * x + y * y) / (2 * *sensor.curvature_radius) : 0;
}

void PadIndenter::validate() const {
  check_shape(shape);
  for (const double p : position)
    require(std::abs(p) <= 1e6, "indenter.position", p, "a place in mm, at most 1e6 from the middle");
  require(std::abs(yaw) <= 360, "indenter.yaw", yaw, "degrees, -360 to 360");
  require(tilt == 0 || (tilts(shape) && tilt > 0 && tilt <= 45), "indenter.tilt", tilt,
          "degrees, 0 to 45, and 0 but for punch and box");
  require(std::abs(tilt_direction) <= 360, "indenter.tilt_direction", tilt_direction, "degrees, -360 to 360");
  if (!young) return;
  require(*young >= 1e-9 && *young <= 1e12, "indenter.young", *young,
          "a Young's modulus in MPa, 1e-9 to 1e12, or left out for a rigid object");
  require(poisson >= 0 && poisson <= 0.5, "indenter.poisson", poisson, "a Poisson's ratio, 0 <= poisson <= 0.5");
}

void PadLoad::validate() const {
  const bool force = !normal_force.empty();
  const std::vector<double>& normal = force ? normal_force : indentation;
  if (normal.empty()) throw ValueError("load.indentation", "[]", "at least one depth in mm (or give normal_force)");
  for (const double value : normal) {
    if (force)
      require(value >= 0 && value <= 1e9, "load.normal_force", value, "a force in N, 0 to 1e9");
    else
      require(value >= 0 && value <= 1e6, "load.indentation", value, "a depth in mm, 0 to 1e6");
  }
  require(indentation_steps >= 1 && indentation_steps <= 1000, "load.indentation_steps", indentation_steps,
          "1 to 1000");
  if (normal.size() * indentation_steps > most_pad_targets)
    throw ValueError(indentation_steps > 1 ? "load.indentation_steps"
                     : force               ? "load.normal_force"
                                           : "load.indentation",
                     std::to_string(indentation_steps > 1 ? indentation_steps : static_cast<int>(normal.size())),
                     "so few that the pressing takes 1000 increments at most");
  require(drags.size() <= 1000, "load.tangential", static_cast<double>(drags.size()), "at most 1000 positions");
  require(moves.size() <= 1000, "load.moves", static_cast<double>(moves.size()), "at most 1000 moves");
  if (!moves.empty() && !drags.empty())
    throw ValueError("load.moves", std::to_string(moves.size()) + " moves", "left out where drags are given");
  for (const PadTarget& move : moves) {
    require(move.normal >= 0 && move.normal <= 1e6, "load.moves", move.normal, "a depth or force, 0 to 1e6");
    require(std::abs(move.x) <= 1e6 && std::abs(move.y) <= 1e6, "load.moves", std::hypot(move.x, move.y),
            "places in mm, at most 1e6 away");
    require(std::abs(move.twist) <= 2 * std::numbers::pi, "load.moves", degrees(move.twist),
            "twists in degrees, -360 to 360");
  }
  const std::size_t targets = pad_targets(*this).size();
  if (!times.empty() && times.size() != targets)
    throw ValueError("load.times", std::to_string(times.size()) + " times",
                     "as many as the load has steps, " + std::to_string(targets));
  for (std::size_t k = 0; k < times.size(); ++k)
    require(times[k] >= (k > 0 ? times[k - 1] : 0) && times[k] <= 1e12, "load.times", times[k],
            "times in s, 0 or more, none before the last");
  for (const auto& drag : drags) {
    for (int axis = 0; axis < 2; ++axis)
      require(std::abs(drag[axis]) <= 1e6, "load.tangential", drag[axis], "a place in mm, at most 1e6 away");
    require(std::abs(drag[2]) <= 2 * std::numbers::pi, "load.twist", clean_degrees(drag[2]), "degrees, -360 to 360");
  }
}

namespace {

void check_map(const FrictionMap& map) {
  const char *key = "contact.friction_map", *allowed = "1 to 64 rows, each of as many numbers, 1 to 64";
  const auto check_count = [&](std::size_t count, bool good) {
    require(good && count >= 1 && count <= 64, key, static_cast<double>(count), allowed);
  };
  check_count(map.rows.size(), true);
  for (const std::vector<double>& row : map.rows) {
    check_count(row.size(), row.size() == map.rows[0].size());
    for (const double mu : row) require(mu >= 0 && mu <= 100, key, mu, "coefficients of friction, 0 to 100");
  }
  check_length("contact.friction_pitch", map.pitch);
}

}  // namespace

void PadScene::set_friction(FrictionMap map) {
  friction = 0;
  for (const std::vector<double>& row : map.rows)
    for (const double mu : row) friction = std::max(friction, mu);
  friction_map = std::move(map);
}

Eigen::VectorXd friction_at(const PadScene& scene, const Eigen::MatrixX2d& places) {
  if (!scene.friction_map) return Eigen::VectorXd::Constant(places.rows(), scene.friction);
  const FrictionMap& map = *scene.friction_map;
  const auto between = [&map](double at, std::size_t count, const auto& value) {
    const double last = static_cast<double>(count - 1), place = std::clamp(at / map.pitch + last / 2, 0.0, last);
    const auto node = static_cast<std::size_t>(place);
    return std::lerp(value(node), value(std::min(node + 1, count - 1)), place - static_cast<double>(node));
  };
  return Eigen::VectorXd::NullaryExpr(places.rows(), [&](Eigen::Index k) {
    return between(places(k, 1), map.rows.size(), [&](std::size_t j) {
      return between(places(k, 0), map.rows[j].size(), [&](std::size_t i) { return map.rows[j][i]; });
    });
  });
}

std::string friction_text(const PadScene& scene) {
  return number_text(scene.friction) + (scene.friction_map ? " at most" : "");
}

void require_times(const PadScene& scene) {
  if (!scene.sensor.relaxation.empty() && scene.load.times.empty())
    throw ValueError("load.times", "none",
                     "given, s of each load step, as sensor.relaxation says that the rubber creeps");
}

void PadScene::validate() const {
  check_title(title);
  fem::validate(sensor);
  indenter.validate();
  load.validate();
  if (friction_map) check_map(*friction_map);
  require(friction >= 0 && friction <= 100, "contact.friction", friction, "a coefficient of friction, 0 to 100");
  if (!load.times.empty() && sensor.relaxation.empty())
    throw ValueError("load.times", std::to_string(load.times.size()) + " times",
                     "left out, or given with sensor.relaxation: elastic rubber has no time");
  if (markers) fem::validate(*markers, sensor);
  if (camera) fem::validate(*camera);
  if (camera && !markers) throw ValueError("camera", "without markers", "given with [markers], which it sees");
}

std::vector<PadTarget> pad_targets(const PadLoad& load) {
  const std::vector<double>& normal = load.normal_force.empty() ? load.indentation : load.normal_force;
  std::vector<PadTarget> targets;
  double from = 0;
  for (const double to : normal) {
    for (int k = 1; k <= load.indentation_steps; ++k)
      targets.push_back({from + (to - from) * k / load.indentation_steps, 0, 0, 0});
    from = to;
  }
  for (const auto& drag : load.drags) targets.push_back({from, drag[0], drag[1], drag[2]});
  targets.insert(targets.end(), load.moves.begin(), load.moves.end());
  return targets;
}

std::size_t pressing_targets(const PadLoad& load) {
  return (load.normal_force.empty() ? load.indentation : load.normal_force).size() *
         static_cast<std::size_t>(load.indentation_steps);
}

double largest_normal(const PadLoad& load) {
  double largest = 0;
  for (const PadTarget& target : pad_targets(load)) largest = std::max(largest, target.normal);
  return largest;
}

}  // namespace tactel::fem
