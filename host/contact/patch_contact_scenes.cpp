// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "fem/layer/linear_elements.h"
#include "fem/layer/patch_exact.h"
#include "fem/layer/patch_reference.h"
#include "fem/layer/patch_solver.h"
#include "host/contact/patch_contact.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

std::ptrdiff_t count_solved(const fem::ContactSolution& solution) {
  return std::ranges::count_if(solution.steps, &fem::ContactStep::converged);
}

/// Keeps the answer that solves more.
void keep_better(fem::ContactSolution& solution, fem::ContactSolution&& other) {
  if (every_step_converged(other) || count_solved(other) > count_solved(solution)) solution = std::move(other);
}

/// Scenes that go into one launch: of one kind.
std::vector<std::vector<std::size_t>> by_kind(std::span<const fem::Scene> scenes) {
  std::vector<std::vector<std::size_t>> groups(4);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const ContactKind kind = kind_of(scenes[i]);
    groups[2 * kind.force + kind.friction].push_back(i);
  }
  std::erase_if(groups, [](const auto& group) { return group.empty(); });
  return groups;
}

/// Scenes of one kind on patches, solved again on larger ones as long as these are too small.
template <class Real>
class GrowingPatches {
 public:
  using Given = typename PatchContact<Real>::Given;
  GrowingPatches(const PatchContact<Real>& contact, std::span<const fem::Scene> scenes,
                 std::vector<fem::ContactSolution>& solutions)
      : contact_(contact), scenes_(scenes), solutions_(solutions), patches_(scenes.size()) {}

  /// Returns the last patch of a scene.
  const fem::Patch& patch(std::size_t i) const { return patches_[i]; }

  /// Solves the scenes `which`. Returns how many patches grew.
  std::size_t solve(std::vector<std::size_t> which) {
    std::vector<Given> given(which.size());
    std::size_t grew = 0;
    for (int growths = 0; !which.empty(); ++growths) {
      std::vector<std::size_t> again;
      std::vector<Given> larger;
      run(which, given, again, larger);
      if (growths == 0) grew = again.size();
      if (growths == contact_.options().most_growths) break;
      which = std::move(again);
      given = std::move(larger);
    }
    return grew;
  }

 private:
  void run(const std::vector<std::size_t>& which, const std::vector<Given>& given, std::vector<std::size_t>& again,
           std::vector<Given>& larger) {
    std::vector<fem::Scene> alike;
    alike.reserve(which.size());
    for (const std::size_t i : which) alike.push_back(scenes_[i]);
    const int elements = contact_.options().elements;
    auto batch = contact_.prepare(alike, given);
    batch.run();
    const typename PatchContact<Real>::Batch::View view(batch);
    for (std::size_t k = 0; k < which.size(); ++k) {
      solutions_[which[k]] = view.solution(k);
      const double left = alike[k].indenter.position + view.patch(k, PATCH_ORIGIN);
      patches_[which[k]] = {left, left + elements * view.patch(k, PATCH_ELEMENT), elements};
      if (auto extent = grown_contact<Real>(view, k, elements)) {
        again.push_back(which[k]);
        larger.push_back(extent);
      }
    }
  }

  const PatchContact<Real>& contact_;
  std::span<const fem::Scene> scenes_;
  std::vector<fem::ContactSolution>& solutions_;
  std::vector<fem::Patch> patches_;  ///< [scenes]
};

/// Solves again what sweeps did not: exactly on the same elements, then by the twin with more sweeps.
template <class Real>
void fall_back(const PatchContact<Real>& contact, const fem::Scene& scene, const fem::Patch& patch,
               fem::ContactSolution& solution) {
  const PatchContactOptions& options = contact.options();
  constexpr int more_sweeps = 10;
  const fem::PatchOptions twin{.elements = options.elements,
                               .tolerance = options.tolerance,
                               .accept = options.accept,
                               .pressing_increments = options.increments,
                               .most_sweeps = more_sweeps * options.most_sweeps,
                               .most_growths = options.most_growths};
  const auto model = contact.model_of(scene.sensor);
  if (patch.right > patch.left)
    keep_better(solution,
                fem::solve_patch_exactly(*model, patch, scene, twin.increments(), {.tolerance = options.accept}));
  if (!every_step_converged(solution)) keep_better(solution, fem::PatchSolver(*model, twin).solve(scene));
  solution.fell_back = true;
}

/// Solves on linear elements what elements of constant pressure resolve badly. Of twice the number a quarter is left
/// for the ends that the search, which has constant ones, misses.
template <class Real>
fem::ContactSolution on_linear_elements(const PatchContact<Real>& contact, const fem::Scene& scene) {
  const PatchContactOptions& options = contact.options();
  const fem::PatchOptions usual{.elements = options.elements, .pressing_increments = options.increments};
  const fem::PatchReferenceOptions reference{.elements = 2 * options.elements,
                                             .pressing_increments = 2 * usual.increments(),
                                             .linear = true,
                                             .exact = {.tolerance = options.accept}};
  const auto model = contact.model_of(scene.sensor);
  fem::ContactSolution solution = fem::PatchReference(*model, reference).solve(scene);
  solution.fell_back = true;
  return solution;
}

/// Whether scenes can share a launch: E and the mesh do not count.
bool same_layer(const fem::Sensor& a, const fem::Sensor& b) {
  return a.length == b.length && a.thickness == b.thickness && a.poisson == b.poisson && a.tactels == b.tactels &&
         a.tactel_span == b.tactel_span && a.tactel_width == b.tactel_width;
}

template <class Real>
void solve_on_sensor(Executor& executor, std::span<const fem::Scene> scenes, const std::vector<std::size_t>& which,
                     const PatchContactOptions& options, std::vector<fem::ContactSolution>& solutions) {
  std::vector<fem::Scene> alike;
  alike.reserve(which.size());
  for (const std::size_t i : which) alike.push_back(scenes[i]);
  const fem::Sensor& sensor = alike.front().sensor;
  const PatchContact<Real> contact(executor, options.sides ? fem::layer_model(sensor) : fem::endless_layer(sensor),
                                   options);
  auto solved = solve_patch_contact(contact, alike);
  for (std::size_t k = 0; k < which.size(); ++k) solutions[which[k]] = std::move(solved[k]);
}

}  // namespace

bool every_step_converged(const fem::ContactSolution& solution) {
  return std::ranges::all_of(solution.steps, &fem::ContactStep::converged);
}

template <class Real>
std::optional<PatchContactExtent> grown_contact(const typename PatchContact<Real>::Batch::View& view, std::size_t i,
                                                int elements) {
  const double left = view.patch(i, PATCH_OUT_LEFT), right = view.patch(i, PATCH_OUT_RIGHT);
  if (!(left > 0 || right > 0)) return std::nullopt;
  const double origin = view.patch(i, PATCH_ORIGIN), width = view.patch(i, PATCH_ELEMENT);
  const auto more = [&](double beyond) { return beyond > 0 ? (beyond + 0.5) * width : 0; };
  return PatchContactExtent{origin - more(left), origin + elements * width + more(right)};
}

template <class Real>
std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<Real>& contact,
                                                      std::span<const fem::Scene> scenes, PatchContactReport* report) {
  for (const fem::Scene& scene : scenes) scene.validate();
  std::vector<fem::ContactSolution> solutions(scenes.size());
  PatchContactReport said;
  GrowingPatches<Real> patches(contact, scenes, solutions);
  for (auto& which : by_kind(scenes)) said.grown += patches.solve(std::move(which));
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const bool wide = fem::needs_linear_pressure(scenes[i].sensor, patches.patch(i).width());
    if (every_step_converged(solutions[i]) && !wide) continue;
    if (wide) {
      solutions[i] = on_linear_elements(contact, scenes[i]);
      ++said.fell_back;
    } else if (contact.options().fallback) {
      fall_back(contact, scenes[i], patches.patch(i), solutions[i]);
      ++said.fell_back;
    }
    said.unsolved += !every_step_converged(solutions[i]);
  }
  if (report) *report = said;
  return solutions;
}

SharedLayers shared_layers(std::span<const fem::Scene> scenes) {
  SharedLayers shared;
  for (const fem::Scene& scene : scenes) {
    const auto own = std::ranges::find_if(shared.sensors,
                                          [&](const fem::Sensor& sensor) { return same_layer(sensor, scene.sensor); });
    shared.of.push_back(static_cast<std::size_t>(own - shared.sensors.begin()));
    if (own == shared.sensors.end()) shared.sensors.push_back(scene.sensor), shared.sensors.back().young = 1;
  }
  return shared;
}

std::vector<fem::ContactSolution> solve_patch_contact(Executor& executor, std::span<const fem::Scene> scenes,
                                                      Precision precision, const PatchContactOptions& options) {
  std::vector<fem::ContactSolution> solutions(scenes.size());
  const SharedLayers shared = shared_layers(scenes);
  std::vector<std::vector<std::size_t>> groups(shared.sensors.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) groups[shared.of[i]].push_back(i);
  for (const auto& which : groups) {
    if (precision == Precision::fp32)
      solve_on_sensor<float>(executor, scenes, which, options, solutions);
    else
      solve_on_sensor<double>(executor, scenes, which, options, solutions);
  }
  return solutions;
}

template std::optional<PatchContactExtent> grown_contact<float>(const PatchContact<float>::Batch::View&, std::size_t,
                                                                int);
template std::optional<PatchContactExtent> grown_contact<double>(const PatchContact<double>::Batch::View&, std::size_t,
                                                                 int);
template std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<float>&, std::span<const fem::Scene>,
                                                               PatchContactReport*);
template std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<double>&, std::span<const fem::Scene>,
                                                               PatchContactReport*);

}  // namespace tactel::host
