// SPDX-License-Identifier: Apache-2.0
#include <tactel/solve.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/api/api_errors.h"
#include "host/api/modelling.h"
#include "host/api/scene_conversion.h"
#include "host/contact/gap_sweep.h"
#include "host/contact/solve.h"
#include "host/contact/solve_on_rung.h"
#include "host/support/errors.h"

namespace tactel {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t chunk = 8192;  ///< scenes between two calls of progress

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

host::SolveOptions options_of(const SolveOptions& from) {
  api::check_precision(from.precision);
  if (from.solver != "batched" && from.solver != "reference")
    throw ConfigError("command line", "--solver", from.solver, "batched or reference");
  host::SolveOptions options;
  options.solver = from.solver, options.precision = from.precision, options.device = from.device;
  options.rung = from.rung, options.accuracy = from.accuracy, options.tolerance = from.tolerance;
  return options;
}

/// Solves scenes of which some are on patches and some on their own meshes, or all on a rung.
class ManySolver {
 public:
  ManySolver(const SolveOptions& options, std::span<const fem::Scene> scenes)
      : options_(options), executor_(host::Device(options.device)) {
    std::vector<fem::Scene> sample;
    const std::size_t count = options.accuracy ? std::min(scenes.size(), api::sample_size) : 0;
    for (std::size_t k = 0; k < count; ++k) sample.push_back(scenes[k * scenes.size() / count]);
    rung_ = api::rung_for_many(executor_, options.rung, options.accuracy, sample);
    patch_ = with_options(rung_.value_or(host::usual_patch()));
  }

  std::vector<fem::ContactSolution> solve(std::span<const fem::Scene> scenes) {
    if (rung_) return host::solve_on_rung(executor_, scenes, patch_, false);
    std::vector<fem::Scene> of_kind[2];
    for (const fem::Scene& scene : scenes) of_kind[on_mesh(scene)].push_back(scene);
    std::vector<fem::ContactSolution> solved[2];
    if (!of_kind[0].empty()) solved[0] = host::solve_on_rung(executor_, of_kind[0], patch_, false);
    if (!of_kind[1].empty()) solved[1] = on_own_meshes(of_kind[1]);
    std::size_t taken[2] = {0, 0};
    std::vector<fem::ContactSolution> all;
    for (const fem::Scene& scene : scenes) all.push_back(std::move(solved[on_mesh(scene)][taken[on_mesh(scene)]++]));
    return all;
  }

  /// Whether all scenes are on one rung, or on patches.
  std::string rung(std::span<const fem::Scene> scenes) const {
    return rung_ || std::ranges::none_of(scenes, on_mesh) ? patch_.name : std::string();
  }
  const char* precision() const { return name(rung_ ? patch_.precision : mesh_precision()); }
  const std::string& device() const { return executor_.device().info().name; }

 private:
  static bool on_mesh(const fem::Scene& scene) { return scene.model == fem::SurfaceModel::mesh; }

  host::Precision mesh_precision() const {
    return options_.precision == "fp64" ? host::Precision::fp64 : host::Precision::fp32;
  }
  host::Rung with_options(host::Rung rung) const {
    if (!options_.precision.empty()) rung.precision = mesh_precision();
    if (options_.tolerance) rung.tolerance = *options_.tolerance * (rung.patch() ? 0.05 : 0.01);  // as solve()
    return rung;
  }
  std::vector<fem::ContactSolution> on_own_meshes(std::span<const fem::Scene> scenes) {
    host::GapSweepOptions sweep;
    sweep.nodes = false;
    if (options_.tolerance) sweep.accept = *options_.tolerance, sweep.tolerance = 0.01 * *options_.tolerance;
    return host::solve_gap_sweep(executor_, scenes, mesh_precision(), sweep);
  }

  SolveOptions options_;
  host::Executor executor_;
  std::optional<host::Rung> rung_;
  host::Rung patch_;
};

/// Puts the answers of a scene into the arrays.
void put_scene(Paths& paths, std::size_t i, const fem::ContactSolution& solution) {
  paths.steps_made[i] = static_cast<std::uint32_t>(solution.steps.size());
  paths.sliding[i] = solution.sliding, paths.fell_back[i] = solution.fell_back;
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    const fem::ContactStep& step = solution.steps[k];
    const std::size_t at = i * paths.steps + k;
    paths.slip_index[at] = step.slip_index.value_or(nan);
    paths.P[at] = step.P, paths.Q[at] = step.Q;
    paths.indentation[at] = step.indentation, paths.tangential[at] = step.tangential;
    paths.converged[at] = step.converged;
    std::ranges::copy(step.sigma_y, paths.sigma_y.begin() + static_cast<std::ptrdiff_t>(at * paths.tactels));
    std::ranges::copy(step.tau_xy, paths.tau_xy.begin() + static_cast<std::ptrdiff_t>(at * paths.tactels));
  }
}

/// Arrays for these answers, filled with NaN.
Paths room_for(const std::vector<fem::ContactSolution>& solutions) {
  Paths paths;
  paths.scenes = solutions.size();
  for (const fem::ContactSolution& solution : solutions) {
    paths.steps = std::max(paths.steps, solution.steps.size());
    for (const fem::ContactStep& step : solution.steps)
      paths.tactels = std::max(paths.tactels, static_cast<std::size_t>(step.sigma_y.size()));
  }
  const std::size_t steps = paths.scenes * paths.steps;
  for (auto* list : {&paths.slip_index, &paths.P, &paths.Q, &paths.indentation, &paths.tangential})
    list->assign(steps, nan);
  paths.sigma_y.assign(steps * paths.tactels, nan), paths.tau_xy.assign(steps * paths.tactels, nan);
  paths.converged.assign(steps, 0);
  paths.steps_made.resize(paths.scenes), paths.sliding.resize(paths.scenes), paths.fell_back.resize(paths.scenes);
  return paths;
}

/// The scenes as the mechanics have them, each checked.
std::vector<fem::Scene> checked_scenes(std::span<const Scene> scenes) {
  std::vector<fem::Scene> all;
  for (const Scene& scene : scenes) {
    all.push_back(api::to_fem(scene));
    api::check_scene(all.back(), "scenes[" + std::to_string(all.size() - 1) + "]");
  }
  return all;
}

}  // namespace

Path solve(const Scene& scene, const SolveOptions& options) {
  const fem::Scene checked = api::to_fem(scene);
  api::check_scene(checked);
  return api::with_public_errors([&] {
    const host::SolveOutcome outcome = host::solve(checked, options_of(options));
    Path path = path_of(outcome);
    if (!options.estimate_error) return path;
    if (const auto error = host::mesh_error(outcome)) {
      const host::AnswerError& e = error->expected;
      path.error = {e.S, e.P, e.Q, e.sigma, e.tau, error->finer};
    }
    return path;
  });
}

Paths solve_many(std::span<const Scene> scenes, const SolveOptions& options, const ProgressFunction& progress) {
  const std::vector<fem::Scene> all = checked_scenes(scenes);
  return api::with_public_errors([&] {
    if (options_of(options).solver != "batched")
      throw ConfigError("command line", "--solver", options.solver, "batched for many scenes");
    if (options.tolerance && !(std::isfinite(*options.tolerance) && *options.tolerance > 0))
      throw ConfigError("command line", "--tolerance", std::to_string(*options.tolerance), "a number above 0");
    ManySolver solver(options, all);
    std::vector<fem::ContactSolution> solutions;
    for (std::size_t first = 0; first < all.size(); first += chunk) {
      if (!progress(first, all.size())) throw Cancelled("solve_many: cancelled by progress");
      auto answers = solver.solve(std::span(all).subspan(first, std::min(chunk, all.size() - first)));
      std::ranges::move(answers, std::back_inserter(solutions));
    }
    Paths paths = room_for(solutions);
    for (std::size_t i = 0; i < solutions.size(); ++i) put_scene(paths, i, solutions[i]);
    paths.rung = solver.rung(all), paths.precision = solver.precision(), paths.device = solver.device();
    progress(all.size(), all.size());
    return paths;
  });
}

}  // namespace tactel
