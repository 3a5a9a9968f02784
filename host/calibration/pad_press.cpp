// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/pad_press.h"

#include <algorithm>
#include <cmath>

#include "fem/angles.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_search.h"
#include "fem/path_derivatives.h"
#include "fem/scene_numbers.h"
#include "host/contact/limits.h"

namespace tactel::host {
namespace {

using Numbers = std::vector<PadShapeNumber>;

constexpr double pad_tolerance = 1e-7;  ///< as the kernel's in fp64; over step_part it leaves 1e-4 of a derivative
constexpr double step_part = 1e-3;      ///< of a number, in differences, which err by some 1e-3; nu: absolute
constexpr double tilt_step = 0.01;      ///< degrees

/// Whether a number of a shape moves a sharp edge.
template <class Shape>
bool moves_sharp_edge(const Shape& shape, const double&) {
  if constexpr (requires { shape.edge; }) return shape.edge == 0;
  return false;
}
bool moves_sharp_edge(const fem::LyingCylinder& cylinder, const double& number) {
  return &number == &cylinder.half_length;
}

void add_number(Numbers& all, const std::string& key, const char* unit, double& value) {
  all.push_back({key, unit, &value});
}
void add_number(Numbers& all, const std::string& key, const char* unit, std::array<double, 2>& both) {
  for (const int axis : {0, 1}) all.push_back({key + "[" + std::to_string(axis) + "]", unit, &both[axis]});
}

/// Adds to the depths of all targets, mm.
void deepen(fem::PadLoad& load, double by) {
  for (double& depth : load.indentation) depth += by;
}

/// Adds degrees to the tilt along x or y of the indenter's frame. Its height at the axis stays.
void tilt(fem::PadIndenter& indenter, int axis, double by, fem::PadLoad& load) {
  const double before = fem::pad_height(indenter, 0, 0), direction = fem::radians(indenter.tilt_direction);
  Eigen::Vector2d total = indenter.tilt * Eigen::Vector2d(std::cos(direction), std::sin(direction));
  total[axis] += by;
  indenter.tilt = total.norm();
  indenter.tilt_direction = fem::degrees(std::atan2(total[1], total[0]));
  deepen(load, fem::pad_height(indenter, 0, 0) - before);
}

/// Changes a number by a step. Returns the step.
double change(PressNumber number, SensorState& state, fem::PadScene& scene) {
  const auto add = [](double& value, double step) { return value += step, step; };
  switch (number) {
    case young_number:
      return add(state.log_young, step_part);
    case poisson_number:
      return add(state.poisson, state.poisson > 0.25 ? -step_part : step_part);  // 0 to 1/2
    case thickness_number:
      return add(state.thickness, step_part * state.thickness);
    case shift_number:
      return add(state.shift, step_part * state.thickness);
    case shift_y_number:
      return add(state.shift_y, step_part * state.thickness);
    case friction_number:
      return add(scene.friction, step_part * scene.friction);
    case tilt_number:
    case tilt_y_number:
      tilt(scene.indenter, number - tilt_number, tilt_step, scene.load);
      return tilt_step;
    case depth_number: {
      const double step = step_part * fem::largest_normal(scene.load);
      deepen(scene.load, step);
      return step;
    }
    case load_number:
      for (double& force : scene.load.normal_force) force *= 1 + step_part;
      return step_part;
    default: {
      double& value =
          *pad_shape_numbers(scene.indenter.shape).at(static_cast<std::size_t>(number - shape_number)).value;
      return add(value, step_part * value);
    }
  }
}

fem::PadScene at_state(fem::PadScene scene, const SensorState& state) {
  scene.sensor.young = std::exp(state.log_young);
  scene.sensor.poisson = state.poisson;
  scene.sensor.thickness = state.thickness;
  scene.sensor.sides = fem::Sides::held;  // free ones take a kernel for each Poisson's ratio and thickness of a fit
  // Where the tactels are elsewhere, so is the indenter for them.
  scene.indenter.position[0] -= state.shift;
  scene.indenter.position[1] -= state.shift_y;
  return scene;
}

}  // namespace

Numbers pad_shape_numbers(fem::PadShape& shape) {
  Numbers all;
  std::visit(
      [&]<class Shape>(Shape& kind) {
        fem::each_number<Shape>(
            [&](const auto& number) { add_number(all, number.key, number.unit, kind.*number.member); });
        std::erase_if(all, [&](const PadShapeNumber& number) { return moves_sharp_edge(kind, *number.value); });
      },
      shape);
  return all;
}

PadPress::PadPress(const fem::PadScene& scene, const PressTiming& timing, const SensorState& first, int cells,
                   int drag_increments)
    : PressModel(timing), scene_(scene) {
  const int steps = scene.load.indentation_steps;
  // A number that follows friction or depth would make derivatives by differences jump.
  options_ = {.cells = cells,
              .tolerance = pad_tolerance,
              .drag_increments = drag_increments,
              .limit_increments = 0,
              .ladder = false};
  options_.pressing_increments = (options_.increments() + steps - 1) / steps;
  std::vector<double>& normals = fem::by_force(scene) ? scene_.load.normal_force : scene_.load.indentation;
  const std::vector<fem::PadTarget> targets = fem::pad_targets(scene.load);
  normals.clear();
  for (std::size_t k = 0; k < fem::pressing_targets(scene.load); ++k) normals.push_back(targets[k].normal);
  scene_.load.indentation_steps = 1;
  const fem::PadScene nominal = at_state(scene_, first);
  fem::PadOptions rough = options_;  // where it touches, not how
  rough.tolerance = fem::PadOptions{}.tolerance;
  refuse_endless(nominal, cells);
  const fem::PadSolution solution = fem::PadSolver(fem::pad_layer(first.poisson), rough).solve(nominal);
  refuse_at_edge(nominal, distance_to_edge(nominal, solution));
  cells_ = solution.cells;
  scene_.indenter = fem::aligned(scene.indenter);
}

PressFrames PadPress::solve(const SensorState& state, const fem::PadScene& scene) const {
  const fem::PadScene moved = at_state(scene, state);
  const fem::PadSolution solution = fem::PadSolver(fem::pad_layer(state.poisson), options_).solve_on(cells_, moved);
  const auto steps = static_cast<Eigen::Index>(solution.steps.size());
  PressFrames result;
  result.frame.resize(steps, channels_of(scene_));
  result.P.resize(steps);
  for (Eigen::Index k = 0; k < steps; ++k) {
    const fem::PadStep& step = solution.steps[static_cast<std::size_t>(k)];
    if (!step.converged) throw fem::PathError("the sweeps of a press on the pad do not converge");
    result.frame.row(k) = step.stress.reshaped().head(result.frame.cols());
    result.P[k] = step.P;
  }
  return result;
}

PressFrames PadPress::stresses(const SensorState& state, double friction, std::span<const PressNumber> numbers) const {
  fem::PadScene scene = scene_;
  scene.friction = friction;
  PressFrames result = solve(state, scene);
  for (const PressNumber number : numbers) {
    if (number == time_constant_number) continue;
    if (number == young_number && !fem::by_force(scene)) {  // stresses over E do not depend on E
      result.frame_by[number] = result.frame, result.P_by[number] = result.P;
      continue;
    }
    SensorState moved = state;
    fem::PadScene other = scene;
    const double step = change(number, moved, other);
    const PressFrames to = solve(moved, other);
    result.frame_by[number] = (to.frame - result.frame) / step;
    result.P_by[number] = (to.P - result.P) / step;
  }
  return result;
}

}  // namespace tactel::host
