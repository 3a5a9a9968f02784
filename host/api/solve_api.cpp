// SPDX-License-Identifier: Apache-2.0
#include <tactel/solve.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/api/api_errors.h"
#include "host/api/many_solver.h"
#include "host/api/outcome.h"
#include "host/api/scene_conversion.h"
#include "host/contact/derivatives.h"
#include "host/contact/solve.h"
#include "host/scenes/unit_warnings.h"
#include "host/support/errors.h"

namespace tactel {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

static_assert(int(NodeStatus::open) == int(fem::GapStatus::open) && int(NodeStatus::slip) == int(fem::GapStatus::slip));
static_assert(int(NodeStatus::stick) == int(fem::GapStatus::stick));

std::vector<double> numbers(const Eigen::VectorXd& from) { return {from.begin(), from.end()}; }

Step step_of(const fem::ContactStep& from) {
  Step step;
  step.indentation = from.indentation, step.tangential = from.tangential;
  step.P = from.P, step.Q = from.Q;
  step.slip_index = from.slip_index.value_or(nan);
  step.slip_distance = from.slip_distance;
  for (const fem::GapStatus status : from.status) step.status.push_back(static_cast<NodeStatus>(status));
  step.normal_force = numbers(from.normal_force), step.tangential_force = numbers(from.tangential_force);
  step.base_force_x = numbers(from.base_force_x), step.base_force_y = numbers(from.base_force_y);
  step.sigma_y = numbers(from.sigma_y), step.tau_xy = numbers(from.tau_xy);
  step.converged = from.converged, step.iterations = from.iterations;
  const fem::Residual& r = from.residual;
  step.residual = {r.penetration, r.cone, r.complementarity, r.drift, r.balance};
  return step;
}

Path path_of(const host::SolveOutcome& outcome) {
  const fem::ContactSolution& solution = outcome.solution;
  Path path;
  for (const fem::ContactStep& step : solution.steps) path.steps.push_back(step_of(step));
  path.surface_x = numbers(solution.surface_x), path.surface_width = numbers(solution.surface_width);
  path.base_x = numbers(solution.base_x), path.tactel_x = numbers(solution.tactel_x);
  path.sliding = solution.sliding, path.fell_back = solution.fell_back;
  path.model = host::model_name(outcome), path.model_reason = outcome.model_reason;
  path.solver = outcome.solver, path.precision = outcome.precision, path.device = outcome.device;
  path.warnings = host::warnings(outcome);
  return path;
}

Derivatives derivatives_of(const host::ContactDerivatives& from) {
  Derivatives all;
  for (const fem::SceneParameter& p : from.parameters) {
    all.names.push_back(p.name);
    all.units.push_back(p.unit);
    all.values.push_back(p.value);
  }
  for (const fem::NoDerivative& m : from.missing) all.missing.push_back(m.name + ": " + m.reason);
  all.distance_to_switch = from.distance_to_switch;
  all.answer_difference = from.answer_difference;
  const auto append = [](std::vector<double>& to, const auto& values) {
    to.insert(to.end(), values.begin(), values.end());
  };
  for (std::size_t k = 0; k < from.distance_to_switch.size(); ++k)
    for (const std::vector<fem::PathAnswer>& by : from.by) {
      const fem::PathAnswer& a = by[k];
      all.P.push_back(a.P);
      all.Q.push_back(a.Q);
      all.slip_index.push_back(a.S.value_or(nan));
      all.indentation.push_back(a.depth);
      all.tangential.push_back(a.x);
      append(all.sigma_y, a.frame.head(a.frame.size() / 2));
      append(all.tau_xy, a.frame.tail(a.frame.size() / 2));
    }
  return all;
}

host::SolveOptions options_of(const SolveOptions& from) {
  host::SolveOptions options = api::to_host(from);
  if (from.solver != "batched" && from.solver != "full-mesh" && from.solver != "reference")
    throw ConfigError("command line", "--solver", from.solver, "batched or full-mesh");
  if (from.solver == "reference") options.solver = "full-mesh";
  return options;
}

}  // namespace

Path solve(const Scene& scene, const SolveOptions& options) {
  return api::with_public_errors([&] {
    const fem::Scene checked = api::to_fem(scene);
    checked.validate();
    host::SolveOutcome outcome = host::solve(checked, options_of(options));
    const auto error = options.estimate_error ? host::mesh_error(outcome) : std::nullopt;
    outcome.mesh_error = error;
    if (options.estimate_error && !error) outcome.no_estimate = host::why_no_estimate(outcome);
    Path path = path_of(outcome);
    if (options.derivatives) path.derivatives = derivatives_of(host::derivatives(checked, outcome));
    if (error)
      path.error = {error->expected.S,     error->expected.P,   error->expected.Q,
                    error->expected.sigma, error->expected.tau, error->finer};
    path.outcome = outcome_of(std::move(outcome));
    return path;
  });
}

Paths solve_many(std::span<const Scene> scenes, const SolveOptions& options, const ProgressFunction& progress) {
  const std::vector<fem::Scene> all = api::checked_scenes(scenes);
  return api::with_public_errors([&] {
    Paths paths = api::solve_paths(api::to_host_for_many(options), all, progress);
    paths.warnings = host::unit_warnings(all);
    progress(all.size(), all.size());
    return paths;
  });
}

}  // namespace tactel
