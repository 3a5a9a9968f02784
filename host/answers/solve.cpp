// SPDX-License-Identifier: Apache-2.0
#include "host/answers/solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "fem/gap/gap_reference.h"
#include "fem/layer/patch_solver.h"
#include "host/contact/lines/contact_stream.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/scenes/ladder.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr int most_columns_asked_twice = 321;  ///< the exact solver takes seconds there
constexpr double rounding_of_Q = 1e-5;         ///< over P, in fp32 sums

SolveOutcome solve_reference(const fem::Scene& scene, const SolveOptions& options) {
  refuse_device_options(options, "--solver full-mesh");
  fem::GapReferenceOptions reference;
  if (options.tolerance) reference.tolerance = *options.tolerance;
  return {fem::solve_gap_reference(scene, reference), "full-mesh", "fp64", "host"};
}

SolveOutcome outcome_on(const Rung& rung, const fem::Scene& scene, fem::ContactSolution solution,
                        const std::string& device, std::string reason) {
  SolveOutcome outcome{std::move(solution), rung.exact ? "reference" : "batched", name(rung.precision),
                       rung.exact ? "host" : device};
  outcome.scene = on_rung(scene, rung);
  outcome.model_reason = std::move(reason);
  if (rung.patch() && !outcome.on_patch()) {
    outcome.scene.sensor = on_mesh(scene, rung).sensor;
    outcome.model_reason = "the contact is not solved on a patch";
  }
  return outcome;
}

/// On the rung that was asked for; where none was, on the usual patch or the scene's own mesh, in fp64 where the device
/// has it: one scene is no work at all.
SolveOutcome solve_batched(const fem::Scene& scene, const SolveOptions& options, bool on_patch) {
  Executor executor{Device(options.device).for_one_contact()};
  const DeviceInfo& device = executor.device().info();
  const bool named = !options.rung.empty();
  Rung rung = named ? rung_named(options.rung) : usual_patch();
  if (!named && device.fp64) rung.precision = Precision::fp64;
  rung.precision = precision_named(options.precision, rung.precision);
  if (options.tolerance) rung.accept_at_most(*options.tolerance);
  ContactModel model = model_of(rung);
  if (!on_patch) {
    GapSweepOptions sweep;
    if (named) sweep.tolerance = rung.tolerance;
    sweep.accept = rung.accept;
    sweep.second_opinion = scene.sensor.columns <= most_columns_asked_twice;
    model.surface = MeshModel{sweep};
  }
  auto solutions = ContactStream(executor, std::move(model)).solve(std::span(&scene, 1));
  if (!on_patch) return {std::move(solutions.front()), "batched", name(rung.precision), device.name};
  return outcome_on(rung, scene, std::move(solutions.front()), device.name,
                    named ? "--rung " + options.rung : "the scene file names no mesh");
}

SolveOutcome solve_to_accuracy(const fem::Scene& scene, const SolveOptions& options) {
  Executor executor{Device(options.device).for_one_contact()};
  RungChoice chosen = plan(std::span(&scene, 1), *options.accuracy,
                           [&](const Rung& rung) { return solve_on_rung(executor, std::span(&scene, 1), rung); });
  SolveOutcome outcome = outcome_on(chosen.rung, scene, std::move(chosen.answers.front()),
                                    executor.device().info().name, fmt::format("--accuracy {:g}", *options.accuracy));
  outcome.rung = chosen.rung, outcome.accuracy = options.accuracy, outcome.plan = std::move(chosen);
  return outcome;
}

/// On the rung that the options name, or the scene's own model.
SolveOutcome solve_as_named(const fem::Scene& scene, const SolveOptions& options, bool on_mesh) {
  const Rung rung = options.rung.empty() ? Rung{} : rung_named(options.rung);
  const bool named = !options.rung.empty(), full_mesh = options.solver == "full-mesh";
  const bool patch = named ? rung.patch() : !on_mesh && scene.model == fem::SurfaceModel::patch;
  const fem::Scene modelled = named && !patch ? host::on_mesh(scene, rung) : scene;
  SolveOutcome outcome = full_mesh ? solve_reference(modelled, options) : solve_batched(modelled, options, patch);
  outcome.rung = rung;
  if (patch && !full_mesh) return outcome;
  outcome.scene = modelled;
  outcome.model_reason = named                                    ? "--rung " + options.rung
                         : scene.model == fem::SurfaceModel::mesh ? "the scene file names a mesh"
                         : full_mesh                              ? "--solver full-mesh solves the mesh"
                                                                  : "a mesh was requested";
  return outcome;
}

/// Whether Q is 0 but for rounding: a symmetric indenter that is pressed and not dragged.
bool only_pressed(const fem::ContactSolution& solution) {
  double P = 0, Q = 0;
  for (const fem::ContactStep& step : solution.steps) P = std::max(P, step.P), Q = std::max(Q, std::abs(step.Q));
  return Q <= rounding_of_Q * P;
}

}  // namespace

std::optional<ExpectedError> mesh_error(const SolveOutcome& outcome, FinerAnswer finer) {
  auto error = outcome.plan ? mesh_error(*outcome.plan) : mesh_error(outcome.scene, outcome.solution, std::move(finer));
  if (error && only_pressed(outcome.solution)) error->expected.Q = 0;  // relative to Q, rounding would be any number
  return error;
}

std::vector<std::string> solver_names() { return {"batched", "full-mesh", "twin"}; }

void check_modelling(const SolveOptions& options) {
  const auto check_positive = [](const char* option, const std::optional<double>& value) {
    if (value && !(std::isfinite(*value) && *value > 0))
      throw ConfigError("command line", option, fmt::format("{:g}", *value), "a number above 0");
  };
  check_positive("--accuracy", options.accuracy);
  check_positive("--tolerance", options.tolerance);
  if (options.solver == "full-mesh" && !options.rung.empty() && rung_named(options.rung).patch())
    throw ConfigError("command line", "--rung", options.rung,
                      "a mesh, with --solver full-mesh; --rung reference is the reference of patches");
  if (!options.accuracy) return;
  const auto refuse = [&](const char* other) {
    throw ConfigError("command line", "--accuracy", fmt::format("{:g}", *options.accuracy),
                      fmt::format("given without {}, which it determines", other));
  };
  if (!options.rung.empty()) refuse("--rung");
  if (options.tolerance) refuse("--tolerance");
  if (!options.precision.empty()) refuse("--precision");
  if (options.solver != "batched") refuse("--solver");
}

void refuse_device_options(const SolveOptions& options, const std::string& solver) {
  if (options.precision == "fp32") throw ConfigError("command line", "--precision", "fp32", "fp64 with " + solver);
  if (!options.device.empty())
    throw ConfigError("command line", "--device", options.device, "left out with " + solver + ", which uses no device");
}

std::string model_name(const SolveOutcome& outcome) {
  const fem::Sensor& s = outcome.scene.sensor;
  const Eigen::VectorXd& width = outcome.solution.surface_width;
  if (outcome.on_patch())
    return fmt::format("patch of {} {}elements, {:.3g} mm wide", width.size(),
                       outcome.solution.linear_elements ? "linear " : "", width.sum());
  return fmt::format("mesh {} x {} {}", s.columns, s.rows, fem::name(s.element));
}

SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options, bool on_mesh) {
  if (options.solver == "twin")
    throw ConfigError("command line", "--solver", "twin", "batched or full-mesh for a line");
  check_modelling(options);
  const bool own_mesh =
      !options.accuracy && options.rung.empty() && (on_mesh || scene.model == fem::SurfaceModel::mesh);
  FinerAnswer finer = options.estimate_error && own_mesh ? begin_finer(scene) : FinerAnswer{};
  SolveOutcome outcome = options.accuracy ? solve_to_accuracy(scene, options) : solve_as_named(scene, options, on_mesh);
  if (!options.estimate_error) return outcome;
  outcome.error = mesh_error(outcome, std::move(finer));
  if (!outcome.error)
    outcome.no_estimate = outcome.plan ? "one of the rungs that were compared misses the contact"
                                       : why_no_estimate(outcome.scene, outcome.solution);
  return outcome;
}

}  // namespace tactel::host
