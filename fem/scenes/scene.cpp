// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/scene.h"

#include <algorithm>
#include <cmath>

#include "fem/numbers/angles.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem {
namespace {

constexpr double most_load_steps = 100000;  // of a path: 5 GB of answers

void check_targets(const std::vector<double>& targets, const char* key, const char* allowed) {
  for (double target : targets) require(std::isfinite(target) && target >= 0, key, target, allowed);
}

void check_normal(const Load& load) {
  check_targets(load.normal_force, "load.normal_force", "a force in N/mm that presses: finite, not below 0");
  if (load.normal_force.empty()) {
    check_targets(load.indentation, "load.indentation", "a depth in mm: finite, not below 0");
    if (load.indentation.empty())
      throw ValueError("load.indentation", "[]", "at least one depth in mm (or give normal_force)");
  }
  require(load.indentation_steps >= 1 && load.indentation_steps <= most_indentation_steps, "load.indentation_steps",
          load.indentation_steps, "a number of equal increments, 1 to 1000");
}

void check_thickness(const Load& load, double thickness) {
  if (!load.normal_force.empty()) return;
  std::vector<double> depths = load.indentation;
  for (const LoadMove& move : load.moves) depths.push_back(move.normal);
  for (double depth : depths)
    if (!(depth < thickness))
      throw ValueError("load.indentation", number_text(depth),
                       "a depth in mm below the rubber's thickness, sensor.thickness = " + number_text(thickness));
}

void check_tangential(const Load& load) {
  for (double x : load.tangential) require(std::isfinite(x), "load.tangential", x, "finite positions in mm");
  require(std::isfinite(load.tangential_step), "load.tangential_step", load.tangential_step,
          "a finite step in mm, 0 for none");
  if (!load.tangential.empty())
    require(load.tangential_step == 0 && !load.tangential_steps, "load.tangential_step", load.tangential_step,
            "left out where load.tangential lists the positions");
  if (!load.tangential_steps) return;
  require(*load.tangential_steps >= 0 && *load.tangential_steps <= most_tangential_steps, "load.tangential_steps",
          *load.tangential_steps, "a number of steps, 0 to 1000");
  require(load.tangential_step != 0 || *load.tangential_steps == 0, "load.tangential_step", load.tangential_step,
          "other than 0 where load.tangential_steps is above 0");
}

void check_moves(const Load& load) {
  if (load.moves.empty()) return;
  if (load.moves.size() > static_cast<std::size_t>(most_tangential_steps))
    throw ValueError("load.moves", std::to_string(load.moves.size()) + " moves", "at most 1000");
  const bool alone = load.tangential.empty() && load.tangential_step == 0 && !load.tangential_steps && !load.angle;
  if (!alone) throw ValueError("load.moves", "given with a drag or an angle", "given alone");
  for (const LoadMove& move : load.moves) {
    require(std::isfinite(move.normal) && move.normal >= 0, "load.moves", move.normal,
            "depths in mm or forces in N/mm: finite, not below 0");
    require(std::isfinite(move.tangential), "load.moves", move.tangential, "finite positions in mm");
  }
}

void check_length(const Load& load) {
  const std::size_t targets = load.normal_force.empty() ? load.indentation.size() : load.normal_force.size();
  const double pressing = static_cast<double>(targets) * load.indentation_steps;
  constexpr const char* allowed = "at most 100000 load steps in all";
  if (pressing > most_load_steps)
    throw ValueError(load.normal_force.empty() ? "load.indentation" : "load.normal_force",
                     number_text(pressing) + " load steps", allowed);
  if (pressing + static_cast<double>(load.tangential.size()) > most_load_steps)
    throw ValueError("load.tangential", std::to_string(load.tangential.size()) + " positions", allowed);
}

void check_angle(const Load& load, double friction) {
  if (!load.angle) return;
  require(!load.normal_force.empty(), "load.angle", *load.angle, "given together with load.normal_force");
  require(load.tangential.empty() && load.tangential_step == 0 && !load.tangential_steps, "load.angle", *load.angle,
          "given without load.tangential and load.tangential_step: the angle sets the tangential force");
  const double limit = degrees(std::atan(friction));
  if (std::abs(*load.angle) < 90 && std::tan(std::abs(radians(*load.angle))) < friction) return;
  throw ValueError("load.angle", number_text(*load.angle),
                   "within the friction angle, -" + number_text(limit) + " < angle < " + number_text(limit) +
                       " degrees (atan of contact.friction = " + number_text(friction) +
                       "): beyond it the contact slides" +
                       (*load.angle == 0 ? "; leave it out for a purely normal load" : ""));
}

/// The lowest part of the profile must be over the rubber, and some part of the profile over a node.
void check_reach(const Scene& scene) {
  const double half = scene.sensor.length / 2, position = scene.indenter.position;
  const Interval lowest = lowest_part(scene.indenter);
  if (!(lowest.left <= half + edge_guard && lowest.right >= -half - edge_guard))
    throw ValueError("indenter.position", number_text(position),
                     "a position that puts the lowest part of the indenter, now at " + number_text(lowest.left) +
                         " to " + number_text(lowest.right) + " mm, over the sensor, from " + number_text(-half) +
                         " to " + number_text(half) + " mm");
  const Eigen::VectorXd nodes = surface_positions(scene.sensor);
  const double along = (std::clamp(position, -half, half) + half) / scene.sensor.length;  // 0 to 1
  if (std::isfinite(profile_height(scene.indenter, nodes[std::lround(along * static_cast<double>(nodes.size() - 1))])))
    return;
  const Eigen::VectorXd heights = profile_heights(scene.indenter, nodes);
  if (!heights.array().isFinite().any())
    throw ValueError("indenter.position", number_text(position),
                     "a position with a surface node under the indenter; the nodes are " +
                         number_text(scene.sensor.length / (scene.sensor.columns - 1)) + " mm apart");
}

bool is_force(const Load& load) { return !load.normal_force.empty(); }

void append_indentation(const Load& load, LoadPath& path) {
  const bool by_force = is_force(load);
  const double tangent = load.angle ? std::tan(radians(*load.angle)) : 0;
  double from = 0;
  for (double target : by_force ? load.normal_force : load.indentation) {
    for (int k = 1; k <= load.indentation_steps; ++k) {
      const double normal = k == load.indentation_steps ? target : from + (target - from) * k / load.indentation_steps;
      path.steps.push_back({by_force, load.angle.has_value(), normal, normal * tangent});
    }
    from = target;
  }
  path.indentation_steps = static_cast<int>(path.steps.size());
}

void append_tangential(const Load& load, LoadPath& path) {
  LoadStep step = path.steps.back();
  const auto drag_to = [&](double position) {
    step.tangential = position;
    path.steps.push_back(step);
  };
  for (const LoadMove& move : load.moves) {
    step.normal = move.normal;
    drag_to(move.tangential);
  }
  if (!load.tangential.empty()) {
    for (double position : load.tangential) drag_to(position);
  } else if (load.tangential_step != 0) {
    path.until_sliding = !load.tangential_steps;
    const int count = load.tangential_steps.value_or(most_tangential_steps);
    for (int k = 1; k <= count; ++k) drag_to(load.tangential_step * k);
  }
}

}  // namespace

void Scene::validate() const {
  check_title(title);
  fem::validate(sensor);
  if (model == SurfaceModel::mesh) require_compressible(sensor);
  fem::validate(indenter);
  require(friction >= 0, "contact.friction", friction, "a coefficient of friction, not below 0, or \"bonded\"");
  check_normal(load);
  check_thickness(load, sensor.thickness);
  check_tangential(load);
  check_moves(load);
  check_length(load);
  check_angle(load, friction);
  check_reach(*this);
}

LoadPath load_path(const Load& load) {
  check_normal(load);
  check_tangential(load);
  check_moves(load);
  check_length(load);
  LoadPath path;
  const std::size_t targets = is_force(load) ? load.normal_force.size() : load.indentation.size();
  path.steps.reserve(targets * static_cast<std::size_t>(load.indentation_steps) + load.moves.size() +
                     load.tangential.size() + static_cast<std::size_t>(load.tangential_steps.value_or(0)));
  append_indentation(load, path);
  if (!load.angle) append_tangential(load, path);
  return path;
}

}  // namespace tactel::fem
