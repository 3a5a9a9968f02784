// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "fem/number_text.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_presses.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/pad_search.h"
#include "fem/value_error.h"
#include "host/contact/pad_judge.h"
#include "host/contact/pad_stream.h"
#include "host/contact/solution_table.h"
#include "host/contact/step_warnings.h"
#include "host/scenes/unit_warnings.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr double near_edge = 2, at_edge = 1;  ///< thicknesses from an edge: warned of, refused
constexpr double most_stress_work = 1e9;      ///< fem::base_stress_work
constexpr double large_error = 0.05;          ///< of S, and of P
constexpr double twin_tolerance = 1e-7;       ///< of sweeps, as the kernel in fp64

void check_pad_options(const SolveOptions& options) {
  if (options.solver != "batched" && options.solver != "twin")
    throw ConfigError("command line", "--solver", options.solver,
                      "batched or twin for a pad; its reference is --rung reference");
  const bool exact = !options.rung.empty() && pad_rung_named(options.rung).exact;
  if (!exact && options.solver == "batched") return check_modelling(options);
  const std::string host = exact ? "--rung reference" : "--solver twin";
  if (exact && options.solver == "twin")
    throw ConfigError("command line", "--solver", "twin", "left out with --rung reference");
  if (options.precision == "fp32") throw ConfigError("command line", "--precision", "fp32", "fp64 with " + host);
  if (!options.device.empty())
    throw ConfigError("command line", "--device", options.device, "left out with " + host + ", which uses no device");
  check_modelling(options);
}

void solve_on_device(PadOutcome& outcome, const SolveOptions& options) {
  Executor executor{Device(options.device).for_one_contact()};
  const DeviceInfo& device = executor.device().info();
  outcome.solver = "batched";
  outcome.precision = !options.precision.empty() ? options.precision : device.fp64 ? "fp64" : "fp32";
  outcome.device = device.name;
  PadModel model = model_of(outcome.rung);
  if (outcome.precision == "fp64") model.precision = Precision::fp64;
  if (options.tolerance) model.options.tolerance = 0, model.options.accept = *options.tolerance;
  outcome.solution = std::move(PadStream(executor, model).solve(std::span(&outcome.scene, 1)).front());
}

void solve_on_host(PadOutcome& outcome, const SolveOptions& options) {
  outcome.precision = "fp64", outcome.device = "host";
  const fem::PadLayer layer = fem::pad_layer(outcome.scene.sensor.poisson);
  if (outcome.rung.exact) {
    outcome.solver = "reference";
    fem::PadReferenceSolution answer = fem::PadReference(layer).solve(outcome.scene);
    outcome.error = PadError{.most95 = answer.error,
                             .largest = answer.error.slip_index,
                             .scenes = "this scene",
                             .from = "half as many cells"};
    outcome.solution = std::move(answer.solution);
    return;
  }
  outcome.solver = "twin";
  fem::PadOptions twin;
  twin.cells = outcome.rung.cells, twin.pressing_increments = outcome.rung.increments;
  twin.tolerance = options.tolerance ? *options.tolerance / fem::slow_on_patch : twin_tolerance;
  if (options.tolerance) twin.accept = *options.tolerance;
  outcome.solution = fem::PadSolver(layer, twin).solve(outcome.scene);
}

bool touches(const fem::PadSolution& solution) {
  return std::ranges::any_of(solution.steps, [](const fem::PadStep& step) { return step.P > 0; });
}

/// Calls f for the place, mm on the pad, of every cell that touches in a step.
template <class F>
void each_touched(const fem::PadSolution& solution, const F& f) {
  for (Eigen::Index i = 0; i < solution.places.rows(); ++i)
    if (std::ranges::any_of(solution.steps, [&](const fem::PadStep& step) { return step.normal_force[i] > 0; }))
      f(Eigen::Vector2d(solution.places.row(i).transpose()));
}

/// Error in S of lines without free sides, at a distance of the contact from the edge over the thickness: by the free
/// sides of lines, nu 0.3 to 0.499 and contacts 1.2 H wide, 0.06 to 0.12 at 0.7 and 0.005 to 0.018 at 2.1; between them
/// it falls exponentially.
double missing_at_edge(double distance, double at_near, double at_far) {
  constexpr double near = 0.7, far = 2.1;
  return at_near * std::pow(at_far / at_near, (distance - near) / (far - near));
}
std::string error_at_edge(double distance) {
  return fmt::format("{:.2g} to {:.2g}", missing_at_edge(distance, 0.06, 0.005),
                     missing_at_edge(distance, 0.12, 0.018));
}

std::optional<std::string> edge_warning(const PadOutcome& outcome) {
  const auto distance = distance_to_edge(outcome.scene, outcome.solution);
  if (!distance || *distance >= near_edge * outcome.scene.sensor.thickness) return std::nullopt;
  const double over = *distance / outcome.scene.sensor.thickness;
  return fmt::format(
      "the contact comes within {:.3g} mm ({:.2g} thicknesses) of the pad's edge: the model has no free sides, which "
      "puts S of lines off by {}",
      *distance, over, error_at_edge(over));
}

std::optional<std::string> error_warning(const PadOutcome& outcome) {
  if (!outcome.error) return std::nullopt;
  const auto& e = outcome.error->most95;
  if (e.slip_index <= large_error && e.P <= large_error) return std::nullopt;
  return fmt::format("S may be off by {:.2g} and P by {}: take a rung with more cells", e.slip_index, percent(e.P));
}

/// Error of P of a step whose contact extends over so few cells: fem::least_across.
double coarse_error(int across) { return across >= 5 ? 0.02 : across >= 3 ? 0.08 : 1; }

/// Steps that hold a history of friction cannot have cells of their own.
std::optional<std::string> few_cells_warning(const PadOutcome& outcome) {
  std::vector<int> across;
  for (const fem::PadStep& step : outcome.solution.steps) across.push_back(step.across);
  const int cells = outcome.solution.cells.n, widest = across.empty() ? 0 : std::ranges::max(across);
  const auto few = few_in_steps(across, fem::least_across(cells, widest));
  if (!few) return std::nullopt;
  return fmt::format(
      "in {} the contact extends over {} of {} cells, which are laid for the deepest step: P there may be off by "
      "{} and S is coarse",
      few->steps, few->fewest, cells, percent(coarse_error(few->fewest)));
}

std::optional<std::string> pad_slip_warning(const PadOutcome& outcome) {
  double worst = 0, limit_there = 0, slipped = 0;
  for (const fem::PadStep& step : outcome.solution.steps) {
    const double limit = slip_limit(std::sqrt(step.area));
    if (limit > 0 && step.slip_distance / limit > worst)
      worst = step.slip_distance / limit, limit_there = limit, slipped = step.slip_distance;
  }
  if (worst <= 1) return std::nullopt;
  return fmt::format(
      "the indenter slides {:.3g} mm over the rubber, more than {:.3g} mm: the model assumes small displacements, "
      "and its profile stays over the cells of its first position",
      slipped, limit_there);
}

/// Below a point load sigma_z falls to a tenth within a thickness: tactels farther apart hardly see what lies between.
bool wide_pitch(const fem::PadSensor& sensor) {
  return std::max(sensor.pitch[0], sensor.pitch[1]) > 2 * sensor.thickness;
}
/// `distance`: from the contact to the middle of the nearest tactel, mm.
bool far_from_tactels(const fem::PadSensor& sensor, double distance) {
  return std::isfinite(distance) && distance - sensor.tactel_size / 2 > sensor.thickness;
}

std::optional<std::string> pitch_warning(const PadOutcome& outcome) {
  const fem::PadSensor& sensor = outcome.scene.sensor;
  if (!wide_pitch(sensor)) return std::nullopt;
  const double H = sensor.thickness, pitch = std::max(sensor.pitch[0], sensor.pitch[1]);
  const Eigen::MatrixX2d tactels = fem::tactel_places(sensor);
  double nearest = std::numeric_limits<double>::infinity();
  each_touched(outcome.solution, [&](const Eigen::Vector2d& place) {
    nearest = std::min(nearest, (tactels.rowwise() - place.transpose()).rowwise().norm().minCoeff());
  });
  if (!far_from_tactels(sensor, nearest)) return std::nullopt;
  return fmt::format(
      "the contact stays {:.3g} mm from the nearest tactel, more than the thickness of {:.3g} mm: with a pitch of "
      "{:.3g} mm the tactels hardly see it",
      nearest, H, pitch);
}

}  // namespace

std::vector<std::string> pad_solver_names() { return {"batched", "twin"}; }

PadOutcome solve(const fem::PadScene& scene, const SolveOptions& options) {
  check_pad_options(options);
  scene.validate();
  PadOutcome outcome;
  outcome.scene = scene;
  outcome.rung = !options.rung.empty() ? pad_rung_named(options.rung)
                 : options.accuracy    ? pad_rungs().front()
                                       : usual_pad_rung();
  outcome.accuracy = options.accuracy;
  PadJudge judge(scene);
  const auto on_rung = [&] {
    refuse_endless(scene, outcome.rung.cells);
    if (outcome.rung.exact || options.solver == "twin")
      solve_on_host(outcome, options);
    else
      solve_on_device(outcome, options);
    if (outcome.rung.exact || !touches(outcome.solution)) return;
    outcome.error = judge.error(outcome.rung, outcome.solution);
    if (!outcome.error) outcome.error = expected_pad_error(outcome.rung, scene, deepest(outcome.solution));
  };
  on_rung();
  refuse_at_edge(scene, distance_to_edge(scene, outcome.solution));
  if (options.accuracy && touches(outcome.solution)) {  // the depth of a force is known now
    const PadRung* rung = &first_pad_rung(scene, *options.accuracy);
    if (rung->name != outcome.rung.name) outcome.rung = *rung, on_rung();
    while (!outcome.kept() && !outcome.rung.exact) outcome.rung = *++rung, on_rung();
  }
  if (!touches(outcome.solution)) outcome.error.reset();
  return outcome;
}

std::string model_name(const PadOutcome& outcome) {
  const fem::PadCells& cells = outcome.solution.cells;
  return fmt::format("{0} x {0} cells of {1:.3g} x {2:.3g} mm", cells.n, cells.hx, cells.hy);
}

void refuse_endless(const fem::PadScene& scene, int cells) {
  const double H = scene.sensor.thickness;
  fem::PadScene seen = scene;
  seen.indenter = fem::aligned(scene.indenter);
  const fem::PadSearch found = fem::find_pad_contact(seen, fem::pad_layer(scene.sensor.poisson));
  const fem::PadCells laid = fem::lay_cells(found, seen, cells, true).cells;
  const auto [least, most] = fem::solvable_sides(H, found.depth);
  if (!fem::solvable(laid, H, found.depth))
    throw ValueError("indenter.shape", fem::shape_name(scene.indenter.shape),
                     fmt::format("one whose contact measures {:.2g} to {:.2g} mm along a side, not {:.3g} x {:.3g} mm",
                                 cells * least, cells * most, cells * laid.hx, cells * laid.hy));
  if (scene.sensor.tactel_size > 0 && fem::base_stress_work(scene, laid) > most_stress_work)
    throw ValueError("sensor.tactel_size", fem::number_text(scene.sensor.tactel_size),
                     fmt::format("a side of fewer thicknesses ({:.3g} mm): the stress under {} x {} tactels of {:.3g} "
                                 "thicknesses takes minutes",
                                 H, scene.sensor.tactels[0], scene.sensor.tactels[1], scene.sensor.tactel_size / H));
}

std::optional<double> distance_to_edge(const fem::PadSensor& sensor, const std::array<double, 2>& position,
                                       const fem::PadBox& reach) {
  double least = std::numeric_limits<double>::infinity();
  const auto along = [&](const std::optional<double>& side, double at, const fem::Interval& to) {
    if (side) least = std::min(least, *side / 2 - std::max(at + to.right, -at - to.left));
  };
  along(sensor.length, position[0], reach.x), along(sensor.width, position[1], reach.y);
  return reach.x.left < reach.x.right && std::isfinite(least) ? std::optional(least) : std::nullopt;
}

std::optional<double> distance_to_edge(const fem::PadScene& scene, const fem::PadSolution& solution) {
  fem::PadBox reach{fem::nowhere, fem::nowhere};
  for (const fem::PadStep& step : solution.steps) reach.cover(step.reach);
  return distance_to_edge(scene.sensor, scene.indenter.position, reach);
}

bool too_near_edge(const fem::PadSensor& sensor, const std::optional<double>& distance) {
  return distance && *distance < at_edge * sensor.thickness;
}

void refuse_at_edge(const fem::PadScene& scene, const std::optional<double>& distance) {
  if (!too_near_edge(scene.sensor, distance)) return;
  throw ValueError("indenter.position", fem::number_text(scene.indenter.position.data(), 2),
                   fmt::format("a place where the contact stays {:.3g} mm (the thickness) from the edges that "
                               "sensor.length and sensor.width give, not {:.3g} mm: the model has no free sides, which "
                               "puts S of lines off by {} at one thickness",
                               scene.sensor.thickness, *distance, error_at_edge(at_edge)));
}

int outside_model(const fem::PadSensor& sensor, const std::array<double, 2>& position, const fem::PadBox& reach,
                  double cell) {
  if (!(reach.x.left < reach.x.right)) return 0;
  int outside = cell > sensor.thickness ? outside_cells : 0;
  if (too_near_edge(sensor, distance_to_edge(sensor, position, reach))) outside += outside_edges;
  if (!wide_pitch(sensor)) return outside;
  double nearest = std::numeric_limits<double>::infinity();
  const Eigen::MatrixX2d tactels = fem::tactel_places(sensor);
  for (Eigen::Index i = 0; i < tactels.rows(); ++i) {
    const double x = tactels(i, 0) - position[0], y = tactels(i, 1) - position[1];
    nearest = std::min(nearest, std::hypot(x - std::clamp(x, reach.x.left, reach.x.right),
                                           y - std::clamp(y, reach.y.left, reach.y.right)));
  }
  return outside + (far_from_tactels(sensor, nearest) ? outside_tactels : 0);
}

std::vector<std::string> warnings(const PadOutcome& outcome) {
  std::vector<std::string> all = unit_warnings(outcome.scene);
  const auto add = [&](std::optional<std::string> warning) {
    if (warning) all.push_back(std::move(*warning));
  };
  add(depth_warning(outcome.scene.sensor.thickness, deepest(outcome.solution)));
  add(untouched_warning(outcome.solution.steps));
  add(few_cells_warning(outcome));
  add(pad_slip_warning(outcome));
  add(error_warning(outcome));
  add(edge_warning(outcome));
  add(pitch_warning(outcome));
  if (outcome.error)
    for (const std::string& what : outcome.error->outside)
      all.push_back("errors were not measured for scenes like this one: " + what);
  return all;
}

}  // namespace tactel::host
