// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/press_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/contact_laws.h"
#include "fem/layer/patch_compliance.h"
#include "fem/layer/rigid_contact.h"
#include "fem/path_derivatives.h"
#include "fem/shape_derivatives.h"
#include "host/calibration/pad_press.h"
#include "host/scenes/scene_source.h"

namespace tactel::host {
namespace {

// Central differences of compliance and stress in the family's tables, which are linear between rows in Poisson's
// ratio.
constexpr double poisson_step = 1e-3, length_step = 1e-3;  // no unit, mm

constexpr double log_step = 1e-4;  ///< of ln RC in central differences: errors of 1e-8

constexpr double sweep_tolerance = 1e-10;  ///< statuses of the exact path; it is solved again with them

/// Compliance and tactel stress at a patch, the tactels shifted: a force is as much nearer or farther. Where the free
/// sides count, the shift moves them along.
fem::Condensation rubber_at(const fem::LayerModel& model, const fem::Patch& patch, double shift) {
  fem::Condensation rubber = fem::patch_condensation(model, patch);
  if (shift != 0) {
    const Eigen::VectorXd moved = rubber.surface_x.array() - shift;
    rubber.tactel_stress = fem::without_compliance(model, moved).tactel_stress;
  }
  return rubber;
}

/// Throws PathError where the statuses of a path are not those of a solution: sweeps that have not converged, or
/// several solutions.
void require_solution(const fem::PathDerivatives& path) {
  constexpr double consistent = -1e-9;  // rounding of an exact solution
  for (const fem::PathAnswer& answer : path.answers())
    if (!(answer.distance_to_switch >= consistent))
      throw fem::PathError("the statuses of its elements do not solve the contact");
}

}  // namespace

double friction_of(const AnyScene& scene) {
  return std::visit([](const auto& press) { return press.friction; }, scene);
}
bool by_force(const AnyScene& scene) {
  return std::visit([](const auto& press) { return fem::by_force(press); }, scene);
}
Eigen::Index channels_of(const AnyScene& scene) {
  return std::visit([](const auto& press) { return inputs_of(press.sensor); }, scene);
}
Eigen::Index tactels_of(const AnyScene& scene) {
  if (const auto* line = std::get_if<fem::Scene>(&scene)) return line->sensor.tactels;
  const auto& [columns, rows] = std::get<fem::PadScene>(scene).sensor.tactels;
  return columns * rows;
}

std::vector<ShapeNumber> shape_numbers(const AnyScene& scene) {
  std::vector<ShapeNumber> all;
  if (const auto* line = std::get_if<fem::Scene>(&scene)) {
    for (const fem::HeightDerivative& number : fem::height_derivatives(line->indenter, Eigen::VectorXd(0)))
      all.push_back({number.key, number.unit, number.value});
  } else {
    fem::PadShape shape = std::get<fem::PadScene>(scene).indenter.shape;
    for (const PadShapeNumber& number : pad_shape_numbers(shape))
      all.push_back({number.key, number.unit, *number.value});
  }
  return all;
}

LinePress::LinePress(const fem::SensorFamily& family, const fem::Scene& scene, const PressTiming& timing,
                     const SensorState& first, int elements)
    : PressModel(timing), family_(family), scene_(scene) {
  scene_.indenter = fem::with_hull(scene.indenter);
  options_.elements = elements;
  options_.tolerance = sweep_tolerance;
  options_.most_sweeps = 20000;
  scene_.sensor = sensor_at(first);
  scene_.validate();
  const fem::LayerModel model = family_.model(scene_.sensor);
  fem::PatchTrace trace;
  fem::PatchSolver(model, options_).solve(scene_, &trace);
  patch_ = trace.patch;
}

fem::Sensor LinePress::sensor_at(const SensorState& state) const {
  fem::Sensor sensor = scene_.sensor;
  sensor.young = std::exp(state.log_young);
  sensor.poisson = state.poisson;
  sensor.thickness = state.thickness;
  return sensor;
}

PressFrames LinePress::stresses(const SensorState& state, double friction, std::span<const PressNumber> numbers) const {
  fem::Scene scene = scene_;
  scene.friction = friction;
  scene.sensor = sensor_at(state);
  const fem::LayerModel model = family_.model(scene.sensor);
  fem::PatchTrace trace;
  fem::PatchSolver(model, options_).solve_on(patch_, scene, &trace);
  const fem::Condensation rubber = rubber_at(model, patch_, state.shift);
  const fem::PathDerivatives path({.compliance = rubber.compliance,
                                   .tactel_stress = rubber.tactel_stress,
                                   .height = fem::profile_heights(scene.indenter, rubber.surface_x),
                                   .mu = std::min(scene.friction, fem::largest_friction),
                                   .young = scene.sensor.young,
                                   .increments = trace.increments});
  require_solution(path);
  const auto steps = static_cast<Eigen::Index>(path.answers().size());
  const auto table = [&](const std::vector<fem::PathAnswer>& answers, Eigen::MatrixXd& frame, Eigen::VectorXd& P) {
    frame.resize(steps, rubber.tactel_stress.rows());
    P.resize(steps);
    for (Eigen::Index k = 0; k < steps; ++k) {
      frame.row(k) = answers[static_cast<std::size_t>(k)].frame;
      P[k] = answers[static_cast<std::size_t>(k)].P;
    }
  };
  PressFrames result;
  table(path.answers(), result.frame, result.P);
  const auto difference = [&](const SensorState& plus, const SensorState& minus, double distance) {
    const fem::Condensation to = rubber_at(family_.model(sensor_at(plus)), patch_, plus.shift),
                            from = rubber_at(family_.model(sensor_at(minus)), patch_, minus.shift);
    return fem::PathDirection{.compliance = (to.compliance - from.compliance) / distance,
                              .tactel_stress = (to.tactel_stress - from.tactel_stress) / distance};
  };
  /// Of the targets of all increments by what is given: mm of a depth, or a force as a whole.
  const auto target = [&](bool force) {
    Eigen::VectorXd by(path.path().increments.size());
    for (Eigen::Index k = 0; k < by.size(); ++k) {
      const fem::LoadStep& step = path.path().increments[static_cast<std::size_t>(k)].target;
      by[k] = step.normal_is_force != force ? 0 : force ? step.normal : 1;
    }
    return by;
  };
  const auto direction_of = [&](PressNumber number) -> fem::PathDirection {
    if (number == young_number) return {.young = scene.sensor.young};
    if (number == friction_number) return {.mu = 1};
    if (number == tilt_number) {
      const Eigen::ArrayXd away = rubber.surface_x.array() - scene.indenter.position;
      return {.height = path.path().height.array().isFinite().select(std::numbers::pi / 180 * away, 0)};
    }
    if (number == depth_number || number == load_number) return {.normal = target(number == load_number)};
    if (number >= shape_number)
      return {.height = fem::height_derivatives(scene.indenter, rubber.surface_x)
                            .at(static_cast<std::size_t>(number - shape_number))
                            .height};
    SensorState plus = state, minus = state;
    if (number == poisson_number) {  // at an end of the family's range the difference is one-sided
      plus.poisson = std::min(state.poisson + poisson_step, family_.range().poisson_high);
      minus.poisson = std::max(state.poisson - poisson_step, family_.range().poisson_low);
      return difference(plus, minus, plus.poisson - minus.poisson);
    }
    plus.*sensor_table[number].member += length_step;  // the thickness or the shift
    minus.*sensor_table[number].member -= length_step;
    return difference(plus, minus, 2 * length_step);
  };
  for (const PressNumber number : numbers)
    if (number != time_constant_number)
      table(path.forward(direction_of(number)), result.frame_by[number], result.P_by[number]);
  return result;
}

PressFrames PressModel::at(const SensorState& state, double friction, std::span<const PressNumber> numbers) const {
  PressFrames frames = stresses(state, friction, numbers);
  for (const PressNumber number : numbers)
    if (number == time_constant_number) frames.P_by[number].setZero(frames.P.size());
  if (std::isfinite(state.log_time_constant)) amplify(state.log_time_constant, numbers, frames);
  return frames;
}

void PressModel::amplify(double log_time_constant, std::span<const PressNumber> numbers, PressFrames& frames) const {
  const auto response = [&](double log) { return amplifier_response(timing_, std::exp(log)); };
  for (const PressNumber number : numbers)
    if (number == time_constant_number)
      frames.frame_by[number] = (response(log_time_constant + log_step) - response(log_time_constant - log_step)) *
                                frames.frame / (2 * log_step);
    else
      frames.frame_by[number] = response(log_time_constant) * frames.frame_by[number];
  frames.frame = response(log_time_constant) * frames.frame;
}

}  // namespace tactel::host
