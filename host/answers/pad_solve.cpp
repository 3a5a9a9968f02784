// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/side_kernel.h"
#include "host/answers/solve.h"
#include "host/contact/limits.h"
#include "host/contact/pads/pad_stream.h"
#include "host/support/errors.h"
#include "host/support/stop_scope.h"

namespace tactel::host {
namespace {

constexpr double twin_tolerance = 1e-7;  ///< of sweeps, as the kernel in fp64

void check_pad_options(const SolveOptions& options) {
  if (options.solver != "batched" && options.solver != "twin")
    throw ConfigError("command line", "--solver", options.solver,
                      "batched or twin for a pad; its reference is --rung reference");
  const bool exact = !options.rung.empty() && rung_named<PadRung>(options.rung).exact;
  if (!exact && options.solver == "batched") return check_modelling(options);
  const std::string host = exact ? "--rung reference" : "--solver twin";
  if (exact && options.solver == "twin")
    throw ConfigError("command line", "--solver", "twin", "left out with --rung reference");
  refuse_device_options(options, host);
  check_modelling(options);
}

void solve_on_device(PadOutcome& outcome, const SolveOptions& options) {
  Executor executor{Device(options.device).for_one_contact()};
  const DeviceInfo& device = executor.device().info();
  outcome.solver = "batched";
  outcome.device = device.name;
  PadModel model = model_of(outcome.rung);
  model.precision = precision_named(options.precision, device.fp64 ? Precision::fp64 : Precision::fp32);
  outcome.precision = name(model.precision);
  if (options.tolerance) model.options.tolerance = 0, model.options.accept = *options.tolerance;
  outcome.solution = std::move(PadStream(executor, model).solve(std::span(&outcome.scene, 1)).front());
}

void solve_on_host(PadOutcome& outcome, const SolveOptions& options) {
  outcome.precision = "fp64", outcome.device = "host";
  const fem::PadLayer layer = fem::pad_layer(outcome.scene);
  if (outcome.rung.exact) {
    outcome.solver = "reference";
    fem::PadOptions reference = fem::pad_reference_options();
    reference.between_sweeps = StopScope::checker();
    fem::PadReferenceSolution answer = fem::PadReference(layer, reference).solve(outcome.scene);
    outcome.error = {
        .expected = answer.error, .from = "half as many cells", .largest = answer.error.S, .scenes = "this scene"};
    outcome.solution = std::move(answer.solution);
    complete(*outcome.error, outcome.scene, outcome.solution);
    return;
  }
  outcome.solver = "twin";
  fem::PadOptions twin = model_of(outcome.rung).options;
  twin.tolerance = options.tolerance ? *options.tolerance / fem::slow_on_patch : twin_tolerance;
  if (options.tolerance) twin.accept = *options.tolerance;
  twin.between_sweeps = StopScope::checker();
  outcome.solution = fem::PadSolver(layer, twin).solve(outcome.scene);
}

bool touches(const fem::PadSolution& solution) {
  return std::ranges::any_of(solution.steps, [](const fem::PadStep& step) { return step.P > 0; });
}

/// States the errors of an answer that touches: beside a second solution on so many cells, or by class. Returns true
/// for the first.
bool state_error(PadOutcome& outcome, PadJudge& judge, int cells) {
  outcome.error = judge.error(outcome.rung, outcome.solution, cells);
  const bool judged = outcome.error.has_value();
  if (!judged)
    outcome.error = expected_pad_error(outcome.rung, outcome.scene, deepest(outcome.scene, outcome.solution));
  complete(*outcome.error, outcome.scene, outcome.solution);
  return judged;
}

void solve_on_rung(PadOutcome& outcome, const PadRung& rung, const SolveOptions& options) {
  outcome.rung = rung;
  refuse_endless(outcome.scene, rung.cells);
  if (rung.exact || options.solver == "twin" || !outcome.scene.sensor.relaxation.empty())
    solve_on_host(outcome, options);
  else
    solve_on_device(outcome, options);
  if (!rung.exact) fem::see_markers(outcome.scene, outcome.solution, StopScope::checker());
  refuse_at_edge(outcome.scene, distance_to_edge(outcome.scene, outcome.solution));
}

/// Whether a second solution on one of ever more cells says that the answer keeps the accuracy; without any, the class
/// of the scene says it.
bool keeps_accuracy(PadOutcome& outcome, PadJudge& judge) {
  bool judged = false;
  for (const int cells : PadJudge::cells(outcome.rung)) {
    if (cells > fem::side_rules(outcome.scene.sensor).most_cells) continue;
    if (!state_error(outcome, judge, cells)) continue;
    if (outcome.kept()) return true;
    judged = true;
  }
  return !judged && outcome.kept();
}

/// Goes up the rungs until one keeps the accuracy. Where there are no second solutions the classes say where to begin.
void pad_to_accuracy(PadOutcome& outcome, PadJudge& judge, const SolveOptions& options) {
  const PadRung* rung = &all_rungs<PadRung>().front();
  solve_on_rung(outcome, *rung, options);
  if (!touches(outcome.solution)) return;
  if (!PadJudge::serves(outcome.solution.steps.size())) rung = &first_pad_rung(outcome.scene, *options.accuracy);
  for (;; ++rung) {
    if (rung->name != outcome.rung.name) solve_on_rung(outcome, *rung, options);
    if (rung->exact || keeps_accuracy(outcome, judge)) return;
  }
}

}  // namespace

PadOutcome solve(const fem::PadScene& scene, const SolveOptions& options) {
  check_pad_options(options);
  scene.validate();
  if (!scene.sensor.relaxation.empty() && !options.device.empty())
    throw ConfigError("command line", "--device", options.device,
                      "left out: rubber that creeps is solved by the twin, without a device");
  PadOutcome outcome;
  outcome.scene = scene, outcome.accuracy = options.accuracy;
  PadJudge judge(scene);
  if (options.accuracy) {
    pad_to_accuracy(outcome, judge, options);
  } else {
    solve_on_rung(outcome, options.rung.empty() ? usual_pad_rung() : rung_named<PadRung>(options.rung), options);
    if (!outcome.rung.exact && touches(outcome.solution))
      state_error(outcome, judge, PadJudge::usual_cells(outcome.rung));
  }
  if (!touches(outcome.solution)) outcome.error.reset();
  return outcome;
}

std::string model_name(const PadOutcome& outcome) {
  const fem::PadCells& cells = outcome.solution.cells;
  return fmt::format("{0} x {0} cells of {1:.3g} x {2:.3g} mm", cells.n, cells.hx, cells.hy);
}

}  // namespace tactel::host
