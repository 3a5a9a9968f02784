// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/contact_fallback.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "fem/gap/contact_laws.h"
#include "fem/gap/gap_condensed.h"
#include "fem/layer/linear_elements.h"
#include "fem/layer/patch_exact.h"
#include "fem/layer/patch_reference.h"
#include "fem/layer/patch_solver.h"
#include "host/contact/lines/gap_sweep_audit.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {
namespace {

std::ptrdiff_t count_solved(const fem::ContactSolution& solution) {
  return std::ranges::count_if(solution.steps, &fem::ContactStep::converged);
}

/// Keeps the answer that solves more.
void keep_better(fem::ContactSolution& solution, fem::ContactSolution&& other) {
  if (every_step_converged(other) || count_solved(other) > count_solved(solution)) solution = std::move(other);
}

/// Solves again what sweeps did not: exactly on the same elements, then by the twin with more sweeps.
template <class Real>
void fall_back(const PatchContact<Real>& contact, const fem::Scene& scene, const fem::Patch& patch,
               fem::ContactSolution& solution) {
  constexpr int more_sweeps = 10;
  fem::PatchOptions twin = contact.options();
  twin.most_sweeps *= more_sweeps;
  const auto model = contact.model_of(scene.sensor);
  if (patch.right > patch.left)
    keep_better(solution,
                fem::solve_patch_exactly(*model, patch, scene, twin.increments(), {.tolerance = twin.accept}));
  if (!every_step_converged(solution)) keep_better(solution, fem::PatchSolver(*model, twin).solve(scene));
  solution.fell_back = true;
}

/// Solves on linear elements what elements of constant pressure resolve badly. Of twice the number a quarter is left
/// for the ends that the search, which has constant ones, misses.
template <class Real>
fem::ContactSolution on_linear_elements(const PatchContact<Real>& contact, const fem::Scene& scene) {
  const fem::PatchOptions& options = contact.options();
  const fem::PatchOptions reference{.elements = 2 * options.elements,
                                    .accept = options.accept,
                                    .pressing_increments = 2 * options.increments(),
                                    .linear = true};
  const auto model = contact.model_of(scene.sensor);
  fem::ContactSolution solution = fem::PatchReference(*model, reference).solve(scene);
  solution.fell_back = true;
  return solution;
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
  if (!every_step_converged(other) || !differ(solution, other, accept)) return;
  if (scene.friction >= fem::largest_friction) solution = std::move(other);
  solution.several = true;
}

}  // namespace

bool every_step_converged(const fem::ContactSolution& solution) {
  return std::ranges::all_of(solution.steps, &fem::ContactStep::converged);
}

PatchCertificate patch_certificate(const LaneAnswer& answer, int elements) {
  const double width = answer.patch(PATCH_ELEMENT), origin = answer.patch(PATCH_ORIGIN);
  const double left = answer.patch(PATCH_OUT_LEFT), right = answer.patch(PATCH_OUT_RIGHT);
  PatchCertificate found{.solved = answer.solved(), .linear = fem::needs_linear_pressure(*answer.sensor, width)};
  const auto more = [&](double beyond) { return beyond > 0 ? (beyond + 0.5) * width : 0; };
  if (left > 0 || right > 0) found.larger = {origin - more(left), origin + elements * width + more(right)};
  return found;
}

template <class Real>
std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<Real>& contact,
                                                      std::span<const fem::Scene> scenes,
                                                      std::vector<PatchCertificate> known, PatchContactReport* report) {
  const fem::PatchOptions& options = contact.options();
  std::vector<fem::ContactSolution> solutions(scenes.size());
  std::vector<fem::Patch> patches(scenes.size());
  PatchContactReport said;
  const bool first = known.empty();
  known.resize(scenes.size());
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (!known[i].linear) which.push_back(i);
  for (int growths = first ? 0 : 1; !which.empty() && growths <= options.most_growths; ++growths) {
    std::map<ContactKind, std::vector<std::size_t>> kinds;
    for (const std::size_t i : which) kinds[kind_of(scenes[i])].push_back(i);
    which.clear();
    for (const auto& [kind, alike] : kinds) {
      typename PatchContact<Real>::Scenes all(contact);
      for (const std::size_t i : alike) all.push_back(scenes[i], fem::load_path(scenes[i].load), known[i].larger);
      auto batch = contact.prepare(std::move(all));
      batch.run();
      const typename ContactBatch<Real>::View view(batch);
      for (std::size_t k = 0; k < alike.size(); ++k) {
        const std::size_t i = alike[k];
        solutions[i] = view.solution(k);
        known[i] = patch_certificate(view.answer(k), options.elements);
        const double left = scenes[i].indenter.position + view.patch(k, PATCH_ORIGIN);
        patches[i] = {left, left + options.elements * view.patch(k, PATCH_ELEMENT), options.elements};
        if (known[i].larger) which.push_back(i);
      }
    }
    if (growths == 0) said.grown = which.size();
  }
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    StopScope::check();
    if (known[i].linear)
      solutions[i] = on_linear_elements(contact, scenes[i]);
    else if (every_step_converged(solutions[i]))
      continue;
    else
      fall_back(contact, scenes[i], patches[i], solutions[i]);
    said.fell_back += solutions[i].fell_back;
    said.unsolved += !every_step_converged(solutions[i]);
  }
  if (report) *report = said;
  return solutions;
}

template <class Real>
std::vector<fem::ContactSolution> solve_gap_sweep(const GapSweep<Real>& sweep, std::span<const fem::Scene> scenes) {
  const GapSweepOptions& options = sweep.options();
  auto batch = sweep.prepare(scenes);
  batch.run();
  std::optional<fem::GapCondensed> made;  // for the first scene that needs it: its numbers have extended precision
  const auto exact = [&]() -> const fem::GapCondensed& {
    if (!made) made.emplace(sweep.condensation(), fem::GapReferenceOptions{.tolerance = options.accept});
    return *made;
  };
  const typename ContactBatch<Real>::View view(batch);
  std::vector<fem::ContactSolution> solutions;
  for (const fem::Scene& scene : scenes) {
    StopScope::check();
    fem::ContactSolution& solution = solutions.emplace_back(view.solution(solutions.size()));
    if (options.audit && options.nodes && options.base_forces) {
      audit_in_fp64(scene, sweep.condensation(), options.accept, solution);
      if (options.force_error && sizeof(Real) == 4 && every_step_converged(solution))
        solution.base_force_error = base_force_error(scene, sweep.condensation(), solution);
    }
    if (!every_step_converged(solution)) {
      if (!options.fallback) continue;
      keep_better(solution, exact().solve(scene));
      solution.fell_back = true;
    } else if (options.second_opinion && scene.friction >= several_solutions_from) {
      ask_again(exact(), scene, options.accept, solution);
    }
  }
  return solutions;
}

template std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<float>&, std::span<const fem::Scene>,
                                                               std::vector<PatchCertificate>, PatchContactReport*);
template std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<double>&, std::span<const fem::Scene>,
                                                               std::vector<PatchCertificate>, PatchContactReport*);
template std::vector<fem::ContactSolution> solve_gap_sweep(const GapSweep<float>&, std::span<const fem::Scene>);
template std::vector<fem::ContactSolution> solve_gap_sweep(const GapSweep<double>&, std::span<const fem::Scene>);

}  // namespace tactel::host
