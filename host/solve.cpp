#include "host/solve.h"

#include <fmt/format.h>

#include <span>

#include "fem/gap_reference.h"
#include "host/errors.h"
#include "host/gap_sweep.h"
#include "host/ladder.h"
#include "host/stress_field.h"

namespace tactel::host {
namespace {

SolveOutcome solve_reference(const fem::Scene& scene, const SolveOptions& options) {
  if (options.precision == "fp32")
    throw ConfigError("command line", "--precision", "fp32", "fp64 with --solver reference");
  if (!options.device.empty())
    throw ConfigError("command line", "--device", options.device,
                      "left out with --solver reference, which uses no device");
  fem::GapReferenceOptions reference;
  if (options.tolerance) reference.tolerance = *options.tolerance;
  return {fem::solve_gap_reference(scene, reference), "reference", "fp64", "host"};
}

/// One scene is no work at all: fp64 unless the device lacks it or fp32 is asked for.
SolveOutcome solve_batched(const fem::Scene& scene, const SolveOptions& options) {
  Executor executor{Device(options.device)};
  const DeviceInfo& device = executor.device().info();
  const Rung* rung = options.rung.empty() ? nullptr : &rung_named(options.rung);
  const bool wanted = rung ? rung->precision == Precision::fp64 : device.fp64;
  const bool fp64 = options.precision.empty() ? wanted : options.precision == "fp64";
  const Precision precision = fp64 ? Precision::fp64 : Precision::fp32;
  GapSweepOptions sweep;
  if (rung) sweep.tolerance = rung->tolerance;
  if (options.tolerance) {
    sweep.accept = *options.tolerance;
    sweep.tolerance =
        0.01 * *options.tolerance;  // a slow lane (contraction 0.99 a sweep) leaves 100 times its last change
  }
  auto solutions = solve_gap_sweep(executor, std::span(&scene, 1), precision, sweep);
  return {std::move(solutions.front()), "batched", name(precision), device.name};
}

SolveOutcome solve_to_accuracy(const fem::Scene& scene, const SolveOptions& options) {
  scene.validate();
  Executor executor{Device(options.device)};
  Plan chosen = plan(std::span(&scene, 1), *options.accuracy,
                     [&](const Rung& rung) { return solve_on_rung(executor, std::span(&scene, 1), rung); });
  SolveOutcome outcome{std::move(chosen.answers.front()), "batched", name(chosen.rung.precision),
                       executor.device().info().name};
  outcome.scene = on_rung(scene, chosen.rung);
  outcome.rung = chosen.rung.name;
  outcome.plan = std::move(chosen);
  return outcome;
}

}  // namespace

bool too_deep(const fem::Sensor& sensor, double indentation) {
  constexpr double rounding = 1e-6;  // of a depth in fp32
  return indentation > linear_strain_limit * (1 + rounding) * sensor.thickness;
}

std::optional<std::string> depth_warning(const fem::Scene& scene, const fem::ContactSolution& solution) {
  double deepest = 0;
  for (const fem::ContactStep& step : solution.steps) deepest = std::max(deepest, step.indentation);
  const double share = deepest / scene.sensor.thickness;
  if (!too_deep(scene.sensor, deepest)) return std::nullopt;
  return fmt::format(
      "the indenter is {:.3g} mm deep, {:.0f} % of the thickness; rubber was measured to be linear up to {:.0f} %",
      deepest, 100 * share, 100 * linear_strain_limit);
}

std::vector<std::string> solver_names() { return {"batched", "reference"}; }

void check_modelling(const SolveOptions& options) {
  if (!options.accuracy) return;
  const auto refuse = [&](const char* other) {
    throw ConfigError("command line", "--accuracy", fmt::format("{:g}", *options.accuracy),
                      fmt::format("left out together with {}: it chooses that itself", other));
  };
  if (!options.rung.empty()) refuse("--rung");
  if (options.tolerance) refuse("--tolerance");
  if (!options.precision.empty()) refuse("--precision");
  if (options.solver != "batched") refuse("--solver reference");
}

SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options) {
  check_modelling(options);
  if (options.accuracy) return solve_to_accuracy(scene, options);
  const fem::Scene modelled = options.rung.empty() ? scene : on_rung(scene, rung_named(options.rung));
  SolveOutcome outcome =
      options.solver == "reference" ? solve_reference(modelled, options) : solve_batched(modelled, options);
  outcome.scene = modelled;
  outcome.rung = options.rung;
  return outcome;
}

}  // namespace tactel::host
