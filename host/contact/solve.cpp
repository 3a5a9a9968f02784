// SPDX-License-Identifier: Apache-2.0
#include "host/contact/solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>

#include "fem/gap_reference.h"
#include "fem/layer/patch_solver.h"
#include "fem/stress_field.h"
#include "host/contact/contact_stream.h"
#include "host/contact/solve_on_rung.h"
#include "host/contact/step_warnings.h"
#include "host/scenes/ladder.h"
#include "host/scenes/unit_warnings.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr int most_columns_asked_twice = 321;  ///< the exact solver takes seconds there
constexpr double share_of_contact = 0.1;       ///< of its width, over which the indenter may slide
constexpr double rounding_of_Q = 1e-5;         ///< over P, in fp32 sums
constexpr double doubtful_forces = 1e-3;       ///< estimated error of base forces from which on fp32 is doubted

SolveOutcome solve_reference(const fem::Scene& scene, const SolveOptions& options) {
  if (options.precision == "fp32")
    throw ConfigError("command line", "--precision", "fp32", "fp64 with --solver full-mesh");
  if (!options.device.empty())
    throw ConfigError("command line", "--device", options.device,
                      "left out with --solver full-mesh, which uses no device");
  fem::GapReferenceOptions reference;
  if (options.tolerance) reference.tolerance = *options.tolerance;
  return {fem::solve_gap_reference(scene, reference), "full-mesh", "fp64", "host"};
}

std::string rung_reason(const SolveOptions& options) {
  if (!options.rung.empty()) return "--rung " + options.rung;
  return options.model ? "a patch was requested" : "the scene file names no mesh";
}

SolveOutcome outcome_on(const Rung& rung, const fem::Scene& scene, fem::ContactSolution solution,
                        const std::string& device, std::string reason) {
  SolveOutcome outcome{std::move(solution), rung.exact ? "reference" : "batched", name(rung.precision),
                       rung.exact ? "host" : device};
  outcome.scene = on_rung(scene, rung);
  outcome.rung = rung.name;
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
  if (!options.precision.empty()) rung.precision = options.precision == "fp64" ? Precision::fp64 : Precision::fp32;
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
  SolveOutcome outcome = outcome_on(rung, scene, std::move(solutions.front()), device.name, rung_reason(options));
  if (!named) outcome.rung.clear();
  return outcome;
}

SolveOutcome solve_to_accuracy(const fem::Scene& scene, const SolveOptions& options) {
  Executor executor{Device(options.device).for_one_contact()};
  RungChoice chosen = plan(std::span(&scene, 1), *options.accuracy,
                           [&](const Rung& rung) { return solve_on_rung(executor, std::span(&scene, 1), rung); });
  SolveOutcome outcome = outcome_on(chosen.rung, scene, std::move(chosen.answers.front()),
                                    executor.device().info().name, fmt::format("--accuracy {:g}", *options.accuracy));
  outcome.plan = std::move(chosen);
  return outcome;
}

/// Whether Q is 0 but for rounding: a symmetric indenter that is pressed and not dragged.
bool only_pressed(const fem::ContactSolution& solution) {
  double P = 0, Q = 0;
  for (const fem::ContactStep& step : solution.steps) P = std::max(P, step.P), Q = std::max(Q, std::abs(step.Q));
  return Q <= rounding_of_Q * P;
}

}  // namespace

std::optional<MeshError> mesh_error(const SolveOutcome& outcome, FinerAnswer finer) {
  auto error = outcome.plan ? mesh_error(*outcome.plan) : mesh_error(outcome.scene, outcome.solution, std::move(finer));
  if (error && only_pressed(outcome.solution)) error->expected.Q = 0;  // relative to Q, rounding would be any number
  return error;
}

std::string why_no_estimate(const SolveOutcome& outcome) {
  if (outcome.plan) return "one of the rungs that were compared misses the contact";
  return why_no_estimate(outcome.scene, outcome.solution);
}

bool too_deep(double thickness, double indentation) {
  constexpr double rounding = 1e-6;  // of a depth in fp32
  return indentation > fem::linear_strain_limit * (1 + rounding) * thickness;
}

std::optional<std::string> depth_warning(double thickness, double deepest) {
  if (!too_deep(thickness, deepest)) return std::nullopt;
  return fmt::format(
      "the indenter is {:.3g} mm deep, {:.0f} % of the thickness; rubber was measured to be linear up to {:.0f} %",
      deepest, 100 * deepest / thickness, 100 * fem::linear_strain_limit);
}

std::optional<std::string> depth_warning(const fem::Scene& scene, const fem::ContactSolution& solution) {
  double deepest = 0;
  for (const fem::ContactStep& step : solution.steps) deepest = std::max(deepest, step.indentation);
  return depth_warning(scene.sensor.thickness, deepest);
}

double slip_limit(double contact_width) { return share_of_contact * contact_width; }

double slip_limit(const fem::Sensor& sensor, double contact_width) {
  return std::max(sensor.length / (sensor.columns - 1), slip_limit(contact_width));
}

double slip_limit(const fem::Sensor& sensor, const fem::ContactSolution& solution, const fem::ContactStep& step) {
  const auto touching = step.normal_force.array() > 0;
  if (solution.surface_width.size() > 0)
    return slip_limit(sensor, touching.select(solution.surface_width.array(), 0.0).sum());
  return slip_limit(sensor, sensor.length / (sensor.columns - 1) * static_cast<double>(touching.count()));
}

std::optional<std::string> slip_warning(const fem::Scene& scene, const fem::ContactSolution& solution) {
  const auto excess = [&](const fem::ContactStep& step) {
    return step.slip_distance / slip_limit(scene.sensor, solution, step);
  };
  const auto worst = std::ranges::max_element(solution.steps, {}, excess);
  if (worst == solution.steps.end() || excess(*worst) <= 1) return std::nullopt;
  return fmt::format(
      "the indenter slides {:.3g} mm over the rubber, more than {:.3g} mm: the model assumes small displacements, "
      "and its profile stays over the nodes of its first position",
      worst->slip_distance, slip_limit(scene.sensor, solution, *worst));
}

bool never_slid(const fem::Scene& scene, const fem::ContactSolution& solution) {
  return fem::load_path(scene.load).until_sliding && !solution.sliding;
}

namespace {

/// On patches, whose elements are laid for the deepest step.
std::optional<std::string> few_elements_warning(const fem::ContactSolution& solution) {
  if (solution.surface_width.size() == 0) return std::nullopt;
  std::vector<int> touched;
  for (const fem::ContactStep& step : solution.steps)
    touched.push_back(static_cast<int>((step.normal_force.array() > 0).count()));
  const auto few = few_in_steps(touched, fem::least_elements);
  if (!few) return std::nullopt;
  return fmt::format(
      "in {} the contact covers {} of {} elements, which are laid for the deepest step: its forces are coarse; a scene "
      "of that depth alone is finer",
      few->steps, few->fewest, solution.surface_width.size());
}

}  // namespace

std::vector<std::string> warnings(const SolveOutcome& outcome) {
  const auto& [scene, solution] = std::tie(outcome.scene, outcome.solution);
  std::vector<std::string> all = unit_warnings(scene);
  if (const auto warning = depth_warning(scene, solution)) all.push_back(*warning);
  if (const auto warning = slip_warning(scene, solution)) all.push_back(*warning);
  if (const auto warning = untouched_warning(solution.steps)) all.push_back(*warning);
  if (const auto warning = few_elements_warning(solution)) all.push_back(*warning);
  if (never_slid(scene, solution) && !solution.steps.empty() && !(solution.steps.back().P > 0))
    all.push_back("the drag until sliding touches nothing: it ends with its first step");
  else if (never_slid(scene, solution))
    all.push_back(fmt::format("the contact does not slide as a whole within {} steps of {:.3g} mm",
                              fem::most_tangential_steps, scene.load.tangential_step));
  const auto raised = [](const fem::ContactStep& step) { return step.P > 0 && step.indentation < 0; };
  if (const auto step = std::ranges::find_if(solution.steps, raised); step != solution.steps.end())
    all.push_back(
        fmt::format("in step {} friction holds the indenter {:.3g} mm above its first touch under P = {:.3g} "
                    "N/mm: other solutions are likely (docs/accuracy.md)",
                    step - solution.steps.begin() + 1, -step->indentation, step->P));
  if (solution.several)
    all.push_back(
        fmt::format("this contact has several solutions: with friction {:g} Coulomb's law does not determine "
                    "it uniquely (docs/accuracy.md)",
                    scene.friction));
  if (solution.base_force_error > doubtful_forces)
    all.push_back(
        fmt::format("in fp32 single base forces may be off by some {:.1g} of the largest, more than the residual "
                    "shows: fp64 resolves them (docs/accuracy.md)",
                    solution.base_force_error));
  if (!outcome.rung.empty() && !carries(outcome.scene.sensor, rung_named(outcome.rung)))
    all.push_back(fmt::format("rung {} requires more than the {} columns that a mesh may have: its mesh is coarser, {}",
                              outcome.rung, fem::most_columns,
                              description(rung_named(outcome.rung), outcome.scene.sensor)));
  if (!outcome.no_estimate.empty())
    all.push_back(fmt::format("the error of this answer is not estimated: {}", outcome.no_estimate));
  return all;
}

std::vector<std::string> solver_names() { return {"batched", "full-mesh"}; }

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

std::string model_name(const SolveOutcome& outcome) {
  const fem::Sensor& s = outcome.scene.sensor;
  const Eigen::VectorXd& width = outcome.solution.surface_width;
  if (outcome.on_patch())
    return fmt::format("patch of {} {}elements, {:.3g} mm wide", width.size(),
                       outcome.solution.linear_elements ? "linear " : "", width.sum());
  return fmt::format("mesh {} x {} {}", s.columns, s.rows, fem::name(s.element));
}

SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options) {
  if (options.solver == "twin")
    throw ConfigError("command line", "--solver", "twin", "batched or full-mesh for a line");
  check_modelling(options);
  if (options.accuracy) return solve_to_accuracy(scene, options);
  const Rung* rung = options.rung.empty() ? nullptr : &rung_named(options.rung);
  const bool full_mesh = options.solver == "full-mesh";
  const fem::SurfaceModel model = options.model.value_or(scene.model);
  if (!full_mesh && (rung ? rung->patch() : model == fem::SurfaceModel::patch))
    return solve_batched(scene, options, true);
  const fem::Scene modelled = rung ? on_mesh(scene, *rung) : scene;
  SolveOutcome outcome = full_mesh ? solve_reference(modelled, options) : solve_batched(modelled, options, false);
  outcome.scene = modelled;
  outcome.rung = options.rung;
  outcome.model_reason = rung                                     ? "--rung " + options.rung
                         : scene.model == fem::SurfaceModel::mesh ? "the scene file names a mesh"
                         : full_mesh                              ? "--solver full-mesh solves the mesh"
                                                                  : "a mesh was requested";
  return outcome;
}

}  // namespace tactel::host
