#include "host/solve.h"

#include <fmt/format.h>

#include <span>

#include "fem/gap_reference.h"
#include "host/errors.h"
#include "host/gap_sweep.h"
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
  const bool fp64 = options.precision.empty() ? device.fp64 : options.precision == "fp64";
  const Precision precision = fp64 ? Precision::fp64 : Precision::fp32;
  GapSweepOptions sweep;
  if (options.tolerance) {
    sweep.accept = *options.tolerance;
    sweep.tolerance =
        0.01 * *options.tolerance;  // a slow lane (contraction 0.99 a sweep) leaves 100 times its last change
  }
  auto solutions = solve_gap_sweep(executor, std::span(&scene, 1), precision, sweep);
  return {std::move(solutions.front()), "batched", name(precision), device.name};
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
      "the indenter is {:.3g} mm deep, {:.0f} % of the thickness; rubber was measured to be linear up to {:.0f} %", deepest,
      100 * share, 100 * linear_strain_limit);
}

std::vector<std::string> solver_names() { return {"batched", "reference"}; }

SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options) {
  return options.solver == "reference" ? solve_reference(scene, options) : solve_batched(scene, options);
}

}  // namespace tactel::host
