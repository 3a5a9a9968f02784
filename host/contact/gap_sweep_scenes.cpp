// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <list>
#include <mutex>
#include <optional>

#include "fem/contact_laws.h"
#include "fem/gap_condensed.h"
#include "host/contact/gap_sweep.h"
#include "host/contact/gap_sweep_audit.h"

namespace tactel::host {
namespace {

std::ptrdiff_t solved_steps(const fem::ContactSolution& solution) {
  return std::ranges::count_if(solution.steps, &fem::ContactStep::converged);
}

bool solved(const fem::ContactSolution& solution) {
  return solved_steps(solution) == static_cast<std::ptrdiff_t>(solution.steps.size());
}

/// Whether two certified answers are different solutions: in P or Q by more than `accept` explains.
bool differ(const fem::ContactSolution& a, const fem::ContactSolution& b, double accept) {
  const double allowed = std::max(1e-6, 10 * accept);
  for (std::size_t k = 0; k < std::min(a.steps.size(), b.steps.size()); ++k) {
    const fem::ContactStep &p = a.steps[k], &q = b.steps[k];
    if (std::abs(p.P - q.P) + std::abs(p.Q - q.Q) > allowed * (q.P + std::abs(q.Q))) return true;
  }
  return a.steps.size() != b.steps.size();
}

/// Compares a solved contact with the exact solver's answer, which starts elsewhere.
void ask_again(const fem::GapCondensed& exact, const fem::Scene& scene, double accept, fem::ContactSolution& solution) {
  fem::ContactSolution other = exact.solve(scene);
  if (!solved(other) || !differ(solution, other, accept)) return;
  if (scene.friction >= fem::largest_friction) solution = std::move(other);
  solution.several = true;
}

/// The exact solver of a launcher's sensor, made for the first scene that needs it: its numbers have extended
/// precision.
class Exact {
 public:
  Exact(const fem::Condensation& condensation, double tolerance) : condensation_(condensation), tolerance_(tolerance) {}
  const fem::GapCondensed& solver() {
    if (!made_) made_.emplace(condensation_, fem::GapReferenceOptions{.tolerance = tolerance_});
    return *made_;
  }

 private:
  const fem::Condensation& condensation_;
  double tolerance_;
  std::optional<fem::GapCondensed> made_;
};

template <class Real>
void solve_alike(const GapSweep<Real>& sweep, std::span<const fem::Scene> scenes, const std::vector<std::size_t>& which,
                 const GapSweepOptions& options, std::vector<fem::ContactSolution>& solutions) {
  std::vector<fem::Scene> alike;
  alike.reserve(which.size());
  for (const std::size_t i : which) alike.push_back(scenes[i]);
  auto batch = sweep.prepare(alike);
  batch.run();
  Exact exact(sweep.condensation(), sweep.options().accept);
  const typename GapSweep<Real>::Batch::View view(batch);
  for (std::size_t k = 0; k < which.size(); ++k) {
    fem::ContactSolution& solution = solutions[which[k]] = view.solution(k);
    if (options.audit && options.nodes && options.base_forces) {
      audit_in_fp64(alike[k], sweep.condensation(), sweep.options().accept, solution);
      if (options.force_error && sizeof(Real) == 4 && solved(solution))
        solution.base_force_error = base_force_error(alike[k], sweep.condensation(), solution);
    }
    if (solved(solution)) {
      if (options.second_opinion && alike[k].friction >= several_solutions_from)
        ask_again(exact.solver(), alike[k], sweep.options().accept, solution);
      continue;
    }
    if (!options.fallback) continue;
    fem::ContactSolution again = exact.solver().solve(alike[k]);
    if (solved(again) || solved_steps(again) > solved_steps(solution)) solution = std::move(again);
    solution.fell_back = true;
  }
}

/// Scenes that share a launch: same sensor but for E, same kind.
std::vector<std::vector<std::size_t>> launches(std::span<const fem::Scene> scenes) {
  std::vector<std::vector<std::size_t>> groups;
  std::vector<std::pair<fem::Sensor, ContactKind>> keys;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    std::pair key(scenes[i].sensor, kind_of(scenes[i]));
    key.first.young = 1;
    const std::size_t group = std::find(keys.begin(), keys.end(), key) - keys.begin();
    if (group == keys.size()) {
      keys.push_back(key);
      groups.emplace_back();
    }
    groups[group].push_back(i);
  }
  return groups;
}

}  // namespace

struct GapSweepSolver::State {
  template <class Real>
  struct Kept {
    fem::Sensor sensor;  ///< E = 1
    GapSweep<Real> launcher;
  };

  template <class Real>
  const GapSweep<Real>& launcher(const fem::Sensor& sensor, std::list<Kept<Real>>& kept) {
    fem::Sensor key = sensor;
    key.young = 1;
    const std::lock_guard lock(making);
    const auto found = std::ranges::find(kept, key, &Kept<Real>::sensor);
    if (found != kept.end()) return found->launcher;
    kept.push_back({key, GapSweep<Real>(executor, sensor, options)});
    return kept.back().launcher;
  }

  Executor& executor;
  Precision precision;
  GapSweepOptions options;
  std::mutex making;  ///< of the next two
  std::list<Kept<float>> singles{};
  std::list<Kept<double>> doubles{};
};

GapSweepSolver::GapSweepSolver(Executor& executor, Precision precision, const GapSweepOptions& options)
    : state_(new State{executor, precision, options, {}}) {}

std::vector<fem::ContactSolution> GapSweepSolver::solve(std::span<const fem::Scene> scenes) const {
  for (const fem::Scene& scene : scenes) scene.validate();
  std::vector<fem::ContactSolution> solutions(scenes.size());
  for (const auto& which : launches(scenes)) {
    const fem::Sensor& sensor = scenes[which.front()].sensor;
    if (state_->precision == Precision::fp32)
      solve_alike(state_->launcher(sensor, state_->singles), scenes, which, state_->options, solutions);
    else
      solve_alike(state_->launcher(sensor, state_->doubles), scenes, which, state_->options, solutions);
  }
  return solutions;
}

std::vector<fem::ContactSolution> solve_gap_sweep(Executor& executor, std::span<const fem::Scene> scenes,
                                                  Precision precision, const GapSweepOptions& options) {
  return GapSweepSolver(executor, precision, options).solve(scenes);
}

}  // namespace tactel::host
