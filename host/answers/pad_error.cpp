// SPDX-License-Identifier: Apache-2.0
#include "host/answers/pad_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/side_kernel.h"
#include "host/contact/pads/pad_stream.h"
#include "host/support/stop_scope.h"

namespace tactel::host {
namespace {

constexpr double beyond_the_measured = 3;
constexpr std::size_t most_compared_steps = 100;
constexpr double finer_tolerance = 1e-4;  ///< of its sweeps
/// Two answers may agree by chance; of pressure below a height map, whose sides cells meet or miss, more often.
constexpr double least_of_map = 0.2;  ///< this over the cells along a side

/// Both solutions beside free sides may miss this much more: of bricks at the sides, which they share at the base, and
/// of edges on them.
AnswerError least_beside_sides(const fem::PadScene& scene) {
  const PadClass kind = pad_class(scene);
  const double P = kind == PadClass::smooth || kind == PadClass::height_map ? 0.01 : 0.015;
  return {.S = 0.006, .P = P, .Q = 0.02, .M = 0.02, .sigma = 0.03, .tau = 0.04};
}

/// Along an axis: a cell in which a table holds the sides, over the contact; 0 where that ends at no side.
double cell_over_contact(double length, double H, double position, const fem::Interval& contact, int cells) {
  const double side = length / 2 * (1 - 1e-4);  // cells end there but for rounding in fp32
  if (position + contact.left > -side && position + contact.right < side) return 0;
  return std::min(length, fem::longest_block * H) / cells / (contact.right - contact.left);
}

/// What both solutions miss of P at a corner: cubics between the cells of the sides' table miss at order 2 what a small
/// contact does beside two sides. On pads of 8 H both have the same cells (docs/notebook/2026-11-29-corners.md).
double least_at_corner(const fem::PadScene& scene, const fem::PadSolution& solution) {
  constexpr double of_cells = 0.04, most = 0.06;
  const fem::PadSensor& sensor = scene.sensor;
  const double H = sensor.thickness, L = sensor.length.value(), W = sensor.width.value();
  const auto over_H = [&](double length) { return std::min(length / H, fem::longest_block); };
  const fem::SideMesh mesh = fem::side_mesh({over_H(L), over_H(W)}, fem::SideBricks::finer);
  fem::PadBox contact{fem::nowhere, fem::nowhere};
  for (const fem::PadStep& step : solution.steps) contact.cover(step.reach);
  const auto [at_x, at_y] = scene.indenter.position;
  const double x = cell_over_contact(L, H, at_x, contact.x, mesh.cells[0]),
               y = cell_over_contact(W, H, at_y, contact.y, mesh.cells[1]);
  return x > 0 && y > 0 ? std::min(of_cells * (x * x + y * y), most) : 0;
}

int finer_increments(int cells) { return cells / 3 * 2; }

/// What errors are of differences from a second solution: `least` and a multiple of them.
struct OverDifferences {
  double least, of_pressure, of_slip;
};

/// Pressure converges at order 1.5 in the cells. Slip, which keeps what each increment leaves, is covered at order 2 by
/// a little more, less where the second solution is finer. So 95 to 98 % of scenes are covered, and by half of what
/// factors that cover all would state (bench/pad_study.cpp, docs/notebook/2026-11-29-answers.md).
OverDifferences over_differences(int cells, int finer) {
  const double ratio = static_cast<double>(cells) / finer;
  return {.least = 0.02 / cells,
          .of_pressure = 1 / (1 - std::pow(ratio, 1.5)),
          .of_slip = (1 + 8.0 / finer) / (1 - ratio * ratio)};
}

/// The same beside free sides, where cells converge at the first order, since tractions at a side are singular.
OverDifferences beside_free_sides(int cells, int finer) {
  const double by_cells = 1.2 / (1 - static_cast<double>(cells) / finer);
  return {.least = 0.004, .of_pressure = by_cells, .of_slip = std::max(by_cells, 2.5)};
}

/// Q and M over mu P that sweeps leave where both are 0.
constexpr double rounding_of_slip = 1e-3;

/// Whether Q and M are 0 but for rounding: an indenter that is pressed without drag, and is symmetric.
bool bears_no_drag(const fem::PadScene& scene, const fem::PadSolution& solution) {
  double tangential = 0, P = 0;
  for (const fem::PadStep& step : solution.steps) {
    tangential = std::max({tangential, step.Q.norm(), std::abs(step.M) / solution.cells.half_size()});
    P = std::max(P, step.P);
  }
  return tangential <= rounding_of_slip * scene.friction * P;
}

}  // namespace

const char* name(PadClass pad_class) {
  static constexpr const char* names[pad_classes] = {"smooth", "sharp edge", "rounded edge", "tilted", "height map"};
  return names[static_cast<int>(pad_class)];
}

PadClass pad_class(const fem::PadScene& scene) {
  if (scene.indenter.tilt != 0) return PadClass::tilted;
  switch (pad_edge(scene.indenter.shape)) {
    case fem::PadEdge::none:
      return PadClass::smooth;
    case fem::PadEdge::rounded:
      return PadClass::rounded_edge;
    case fem::PadEdge::measured:
      return PadClass::height_map;
    default:
      return PadClass::sharp_edge;
  }
}

std::vector<std::string> outside(const MeasuredPadScenes& measured, const fem::PadScene& scene, double depth) {
  constexpr double rounding = 1e-6;  // of a depth in fp32
  std::vector<std::string> all;
  const auto check = [&](const char* what, double value, const fem::Interval& in) {
    if (value < in.left * (1 - rounding) || value > in.right * (1 + rounding))
      all.push_back(fmt::format("{} {:.3g} (measured {:g} to {:g})", what, value, in.left, in.right));
  };
  check("sensor.poisson", scene.sensor.poisson, measured.poisson);
  check("depth over thickness", depth / scene.sensor.thickness, measured.depth);
  if (!scene.sensor.layers.empty()) all.push_back("layers upon layers");
  if (!scene.sensor.relaxation.empty()) all.push_back("rubber that creeps");
  if (scene.friction_map) all.push_back("a map of friction");
  if (scene.sensor.depth > 0) all.push_back("tactels above the base");
  if (scene.friction > 0) check("friction", scene.friction, measured.friction);
  return all;
}

std::string judged_by(const ExpectedError& error) {
  if (!error.from.empty()) return "beside " + error.from;
  return error.outside.empty() ? "95 % of scenes, " + error.scenes : "three times that of measured scenes";
}

double deepest(const fem::PadScene& scene, const fem::PadSolution& solution) {
  const double nu = scene.sensor.poisson, soft = fem::soft_object(scene.sensor, scene.indenter).normal(),
               share = has_flat_face(scene) ? 0.5 : 0.75;  // of a half-space below a flat punch and a ball, P / (E a)
  double depth = 0;
  for (const fem::PadStep& step : solution.steps) {
    const double thick = step.indentation / (1 + soft / (1 - nu * nu)), a = std::sqrt(step.area / std::numbers::pi);
    const double of_object = soft > 0 && step.P > 0 ? share * soft * step.P / (scene.sensor.young * a) : 0;
    depth = std::max(depth, std::min(thick, step.indentation - of_object));
  }
  return depth;
}

bool has_flat_face(const fem::PadScene& scene) {
  const fem::PadEdge edge = pad_edge(scene.indenter.shape);
  return edge != fem::PadEdge::none && edge != fem::PadEdge::ends;
}

double strain_error(const fem::PadScene& scene, const fem::PadSolution& solution) {
  const double H = scene.sensor.thickness, strain = deepest(scene, solution) / H;
  if (has_flat_face(scene)) return 1.6 * strain;
  return solution.cells.half_size() > 1.5 * H ? std::max(0.013, 0.5 * strain) : 0.013;
}

double curvature_error(const fem::PadSensor& sensor) {
  return sensor.curvature_radius ? 0.7 * sensor.thickness / *sensor.curvature_radius : 0;
}

void complete(ExpectedError& error, const fem::PadScene& scene, const fem::PadSolution& solution) {
  AnswerError& e = error.expected;
  if (bears_no_drag(scene, solution)) e.Q = e.M = 0;  // relative to them, rounding would be any number
  if (by_force(scene)) return;
  error.strain = strain_error(scene, solution) + curvature_error(scene.sensor);
  e.P += error.strain, e.sigma += error.strain;
}

const PadErrors& class_errors(const PadRung& rung, const fem::PadScene& scene) {
  const auto measured = std::ranges::find(measured_pads(), rung.name, &MeasuredPadRung::name);
  return measured->of[static_cast<int>(pad_class(scene))];
}

const PadRung& first_pad_rung(const fem::PadScene& scene, double accuracy) {
  const std::vector<PadRung>& rungs = all_rungs<PadRung>();
  return *std::find_if(rungs.begin(), std::prev(rungs.end(), 2),
                       [&](const PadRung& rung) { return class_errors(rung, scene).most95.S <= accuracy; });
}

ExpectedError expected_pad_error(const PadRung& rung, const fem::PadScene& scene, double depth) {
  const PadErrors& errors = class_errors(rung, scene);
  ExpectedError error{.expected = errors.most95,
                      .largest = errors.largest,
                      .scenes = name(pad_class(scene)),
                      .outside = outside(measured_classes, scene, depth)};
  if (error.outside.empty()) return error;
  error.expected = scaled(error.expected, beyond_the_measured);
  double& S = error.expected.S;
  S = std::min(1.0, S), error.largest = std::max(error.largest, S);
  return error;
}

const PadRung& cheapest_pad_rung(std::span<const fem::PadScene> scenes, double accuracy,
                                 const std::function<double(std::size_t k)>& depth) {
  const auto keeps = [&](const PadRung& rung) {
    for (std::size_t k = 0; k < scenes.size(); ++k)
      if (expected_pad_error(rung, scenes[k], depth(k)).expected.S > accuracy) return false;
    return true;
  };
  return *std::ranges::find_if(all_rungs<PadRung>(), [&](const PadRung& r) { return r.exact || keeps(r); });
}

std::vector<int> PadJudge::cells(const PadRung& rung) {
  std::vector<int> all;
  for (const int n : {16, 24, 32, 48})
    if (n > rung.cells && n <= 2 * rung.cells) all.push_back(n);
  return all;
}

bool PadJudge::serves(std::size_t steps) { return steps <= most_compared_steps; }

const fem::PadSolution& PadJudge::finer(int cells) {
  if (const auto made = finer_.find(cells); made != finer_.end()) return made->second;
  const fem::PadOptions options{.cells = cells,
                                .tolerance = finer_tolerance,
                                .pressing_increments = finer_increments(cells),
                                .drag_increments = 2,
                                .side_bricks = fem::SideBricks::finer,
                                .whole_path = false,
                                .between_sweeps = StopScope::checker()};
  const fem::PadLayer layer = fem::pad_layer(scene_);
  fem::PadSolution solution = fem::PadSolver(layer, options).solve(scene_);
  fem::see_markers(scene_, solution, options.between_sweeps);
  return finer_.emplace(cells, std::move(solution)).first->second;
}

std::optional<ExpectedError> PadJudge::error(const PadRung& rung, const fem::PadSolution& answer, int cells) {
  if (!serves(answer.steps.size())) return {};
  const fem::PadSolution& other = finer(cells);
  if (!every_step_converged(other)) return {};
  ExpectedError error{.expected = fem::pad_difference(answer, other),
                      .from = fmt::format("{0} x {0} cells", other.cells.n),
                      .scenes = "this scene",
                      .outside = outside(measured_judge, scene_, deepest(scene_, answer))};
  const bool free = fem::has_free_sides(scene_.sensor);
  const OverDifferences over = (free ? beside_free_sides : over_differences)(rung.cells, other.cells.n);
  AnswerError beside_sides = free ? least_beside_sides(scene_) : AnswerError{};
  if (free) beside_sides.P += least_at_corner(scene_, answer);
  const bool map = pad_class(scene_) == PadClass::height_map;
  for (const auto member : fem::pad_error_members) {
    double& e = error.expected.*member;
    if (!std::isfinite(e)) return {};
    if (e == 0) continue;  // without friction
    const bool of_pressure = member == &AnswerError::P || member == &AnswerError::sigma;
    e = over.least + beside_sides.*member + e * (of_pressure ? over.of_pressure : over.of_slip);
    if (of_pressure && map) e += least_of_map / rung.cells;
  }
  error.expected.S = std::min(1.0, error.expected.S);
  error.largest = std::min(1.0, 2 * error.expected.S);
  return error;
}

}  // namespace tactel::host
