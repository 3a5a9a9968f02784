// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad.h>

#include <limits>

#include "host/answers/solve.h"
#include "host/answers/step_quantities.h"
#include "host/answers/warnings.h"
#include "host/api/conversion.h"
#include "host/api/states.h"
#include "host/support/errors.h"

namespace tactel {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

static_assert(int(NodeStatus::open) == int(fem::GapStatus::open) && int(NodeStatus::slip) == int(fem::GapStatus::slip));
static_assert(int(NodeStatus::stick) == int(fem::GapStatus::stick));

std::vector<double> numbers(const auto& from) { return {from.begin(), from.end()}; }

template <class Value>
concept OfLaws = requires(Value& value) {
  host::residuals(value);
};

// Sets a member of a public step to the value of a step of fem.

void assign(double& to, const std::optional<double>& from) { to = from.value_or(undefined); }
void assign(std::array<double, 2>& to, const Eigen::Vector2d& from) { to = {from[0], from[1]}; }
void assign(std::vector<double>& to, const auto& from) { to = numbers(from); }
void assign(std::vector<NodeStatus>& to, const std::vector<fem::GapStatus>& from) {
  for (const fem::GapStatus status : from) to.push_back(static_cast<NodeStatus>(status));
}
void assign(std::vector<std::array<double, 2>>& to, const Eigen::MatrixX2d& from) {
  for (const auto& row : from.rowwise()) to.push_back({row[0], row[1]});
}
void assign(std::vector<std::array<double, 3>>& to, const Eigen::MatrixX3d& from) {
  for (const auto& row : from.rowwise()) to.push_back({row[0], row[1], row[2]});
}
void assign(auto& to, const auto& from) { to = from; }
void assign(OfLaws auto& to, const auto& from) {
  host::each_pair(host::residuals(to), host::residuals(from), [](double& law, double value) { law = value; });
}

/// What paths of both kinds take of an answer.
template <class Path>
Path path_with_steps(const auto& outcome) {
  Path path;
  for (const auto& step : outcome.solution.steps)
    host::each_pair(host::quantities<false>(path.steps.emplace_back()), host::quantities<false>(step),
                    [](auto& to, const auto& from) { assign(to, from); });
  path.fell_back = outcome.solution.fell_back, path.model = host::model_name(outcome);
  path.solver = outcome.solver, path.precision = outcome.precision, path.device = outcome.device;
  path.warnings = host::warnings(outcome);
  return path;
}

Path path_of(const host::SolveOutcome& outcome) {
  const fem::ContactSolution& solution = outcome.solution;
  Path path = path_with_steps<Path>(outcome);
  path.surface_x = numbers(solution.surface_x), path.surface_width = numbers(solution.surface_width);
  path.base_x = numbers(solution.base_x), path.tactel_x = numbers(solution.tactel_x);
  path.sliding = solution.sliding, path.model_reason = outcome.model_reason;
  if (const auto& error = outcome.error) {
    const host::AnswerError& e = error->expected;
    path.error = {e.S, e.P, e.Q, e.sigma, e.tau, error->from};
  }
  return path;
}

PadPath path_of(const host::PadOutcome& outcome) {
  const fem::PadSolution& solution = outcome.solution;
  PadPath path = path_with_steps<PadPath>(outcome);
  path.cell_x = numbers(solution.places.col(0)), path.cell_y = numbers(solution.places.col(1));
  path.cell_width = {solution.cells.hx, solution.cells.hy};
  const auto [nx, ny] = outcome.scene.sensor.tactels;
  path.axes = outcome.scene.sensor.axes;
  const Eigen::MatrixX2d tactels = fem::tactel_places(outcome.scene.sensor);
  path.tactel_x = numbers(tactels.col(0).head(nx));
  for (Eigen::Index j = 0; j < ny; ++j) path.tactel_y.push_back(tactels(j * nx, 1));
  path.rung = outcome.rung.name;
  if (const auto& error = outcome.error) {
    const host::AnswerError& e = error->expected;
    path.error = {e.S, error->largest, error->strain, error->scenes, error->outside, e.P, e.Q,
                  e.M, e.sigma,        e.tau,         error->from,   e.markers};
  }
  return path;
}

SolveOptions options_of_line(SolveOptions options) {
  api::check_precision(options.precision);
  if (options.solver != "batched" && options.solver != "full-mesh" && options.solver != "reference")
    throw ConfigError("command line", "--solver", options.solver, "batched or full-mesh");
  if (options.solver == "reference") options.solver = "full-mesh";
  return options;
}

}  // namespace

Path solve(const Scene& scene, const SolveOptions& options) {
  return api::with_public_errors([&] {
    const fem::Scene made = api::to_fem(scene);
    made.validate();
    host::SolveOutcome outcome = host::solve(made, options_of_line(options));
    Path path = path_of(outcome);
    path.outcome = outcome_of(std::move(outcome));
    return path;
  });
}

PadPath solve(const PadScene& scene, const SolveOptions& options) {
  return api::with_public_errors([&] {
    api::check_precision(options.precision);
    host::PadOutcome outcome = host::solve(api::to_fem(scene), options);
    PadPath path = path_of(outcome);
    path.outcome = outcome_of(std::move(outcome));
    return path;
  });
}

}  // namespace tactel
