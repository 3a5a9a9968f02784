// SPDX-License-Identifier: Apache-2.0
#include "host/answers/pad_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/overloaded.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/side_kernel.h"
#include "host/contact/pad_stream.h"

namespace tactel::host {
namespace {

constexpr double beyond_the_measured = 3;
constexpr std::size_t most_compared_steps = 100;
constexpr double finer_tolerance = 1e-4;  ///< of its sweeps
/// Errors over differences. Cells converge at order 1.5, which pressure and P show; increments at the first, so that
/// twice as many show half of what slip leaves. A fifth or fourth more covers 95 % of scenes (bench/pad_study.cpp).
constexpr double order = 1.5, more = 1.2, by_increments = 2.5;
/// Two answers may agree by chance; of pressure below a height map, whose sides cells meet or miss, more often.
constexpr double least = 0.004, least_of_map = 0.2;  ///< this over the cells along a side

/// With free sides cells converge at the first order, since tractions at a side are singular, and both solutions may
/// miss this much more: of bricks at the sides, which they share at the base, and of edges on them.
constexpr double side_order = 1;
AnswerError least_beside_sides(const fem::PadScene& scene) {
  const PadClass of = pad_class(scene);
  const double P = of == PadClass::smooth || of == PadClass::height_map ? 0.01 : 0.015;
  return {.S = 0.006, .P = P, .Q = 0.02, .M = 0.02, .sigma = 0.03, .tau = 0.04};
}

int finer_cells(const PadRung& rung) { return std::max(24, 4 * rung.cells / 3); }
int finer_increments(int cells) { return cells / 3 * 2; }

}  // namespace

const char* name(PadClass pad_class) {
  static constexpr const char* names[pad_classes] = {"smooth", "sharp edge", "rounded edge", "tilted", "height map"};
  return names[static_cast<int>(pad_class)];
}

PadClass pad_class(const fem::PadScene& scene) {
  if (scene.indenter.tilt != 0) return PadClass::tilted;
  const auto edge_of = [](double edge) { return edge > 0 ? PadClass::rounded_edge : PadClass::sharp_edge; };
  return std::visit(fem::Overloaded{[](const fem::Sphere&) { return PadClass::smooth; },
                                    [](const fem::Paraboloid&) { return PadClass::smooth; },
                                    [](const fem::Cone&) { return PadClass::smooth; },
                                    [](const fem::LyingCylinder&) { return PadClass::sharp_edge; },
                                    [&](const fem::Punch& punch) { return edge_of(punch.edge); },
                                    [&](const fem::Box& box) { return edge_of(box.edge); },
                                    [](const fem::HeightMap&) { return PadClass::height_map; }},
                    scene.indenter.shape);
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
  if (scene.friction > 0) check("friction", scene.friction, measured.friction);
  return all;
}

std::string judged_by(const ExpectedError& error) {
  if (!error.from.empty()) return "beside " + error.from;
  return error.outside.empty() ? "95 % of scenes, " + error.scenes : "three times that of measured scenes";
}

double deepest(const fem::PadSolution& solution) {
  double depth = 0;
  for (const fem::PadStep& step : solution.steps) depth = std::max(depth, step.indentation);
  return depth;
}

const PadErrors& class_errors(const PadRung& rung, const fem::PadScene& scene) {
  const auto measured = std::ranges::find(measured_pads(), rung.name, &MeasuredPadRung::name);
  return measured->of[static_cast<int>(pad_class(scene))];
}

const PadRung& first_pad_rung(const fem::PadScene& scene, double accuracy) {
  const std::vector<PadRung>& rungs = pad_rungs();
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
  for (const auto member : fem::pad_error_members) error.expected.*member *= beyond_the_measured;
  double& S = error.expected.S;
  S = std::min(1.0, S), error.largest = std::max(error.largest, S);
  return error;
}

const fem::PadSolution& PadJudge::finer(int cells) {
  if (const auto made = finer_.find(cells); made != finer_.end()) return made->second;
  const fem::PadOptions options{.cells = cells,
                                .tolerance = finer_tolerance,
                                .pressing_increments = finer_increments(cells),
                                .drag_increments = 2,
                                .side_bricks = fem::SideBricks::finer,
                                .whole_path = false};
  const fem::PadLayer layer = fem::pad_layer(scene_.sensor.poisson);
  return finer_.emplace(cells, fem::PadSolver(layer, options).solve(scene_)).first->second;
}

std::optional<ExpectedError> PadJudge::error(const PadRung& rung, const fem::PadSolution& answer) {
  if (answer.steps.size() > most_compared_steps) return {};
  const fem::PadSolution& other = finer(finer_cells(rung));
  if (!every_step_converged(other)) return {};
  ExpectedError error{.expected = fem::pad_difference(answer, other),
                      .from = fmt::format("{0} x {0} cells", other.cells.n),
                      .scenes = "this scene",
                      .outside = outside(measured_judge, scene_, deepest(answer))};
  const bool free = fem::has_free_sides(scene_.sensor);
  const double ratio = static_cast<double>(rung.cells) / other.cells.n,
               by_cells = more / (1 - std::pow(ratio, free ? side_order : order));
  const AnswerError beside_sides = free ? least_beside_sides(scene_) : AnswerError{};
  const bool map = std::holds_alternative<fem::HeightMap>(scene_.indenter.shape);
  for (const auto member : fem::pad_error_members) {
    double& e = error.expected.*member;
    if (!std::isfinite(e)) return {};
    if (e == 0) continue;  // without friction
    const bool of_pressure = member == &AnswerError::P || member == &AnswerError::sigma;
    e = least + beside_sides.*member + e * (of_pressure ? by_cells : std::max(by_cells, by_increments));
    if (of_pressure && map) e += least_of_map / rung.cells;
  }
  error.expected.S = std::min(1.0, error.expected.S);
  error.largest = std::min(1.0, 2 * error.expected.S);
  return error;
}

}  // namespace tactel::host
