// SPDX-License-Identifier: Apache-2.0
#include "host/contact/solve_on_rung.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>

#include "fem/layer/layer_model.h"
#include "fem/layer/patch_reference.h"
#include "fem/load_stepping.h"
#include "host/contact/patch_contact.h"
#include "host/support/side_by_side.h"

namespace tactel::host {
namespace {

/// With much friction near nu = 1/2, many elements may have no solution that meets the tolerance where fewer have one.
fem::ContactSolution solve_exactly(const fem::LayerModel& model, const fem::Scene& scene, const Rung& rung) {
  fem::ContactSolution answer;
  for (const int share : {1, 2, 4}) {
    fem::PatchReferenceOptions options{.elements = rung.elements / share, .pressing_increments = rung.steps};
    if (rung.accept > 0) options.exact.tolerance = rung.accept;
    answer = fem::PatchReference(model, options).solve(scene);
    if (every_step_converged(answer)) break;
  }
  return answer;
}

std::vector<fem::ContactSolution> on_patches(Executor& executor, std::span<const fem::Scene> scenes, const Rung& rung) {
  if (!rung.exact) return solve_patch_contact(executor, scenes, rung.precision, patch_options(rung));
  const SharedLayers shared = shared_layers(scenes);
  const std::vector<fem::Sensor>& sensors = shared.sensors;
  std::vector<std::optional<fem::LayerModel>> models(sensors.size());
  side_by_side(sensors.size(), executor.threads(), [&](std::size_t k) { models[k] = fem::layer_model(sensors[k]); });
  std::vector<fem::ContactSolution> answers(scenes.size());
  side_by_side(scenes.size(), executor.threads(),
               [&](std::size_t i) { answers[i] = solve_exactly(*models[shared.of[i]], scenes[i], rung); });
  return answers;
}

}  // namespace

PatchContactOptions patch_options(const Rung& rung) {
  PatchContactOptions options;
  options.elements = rung.elements;
  options.increments = rung.steps;
  options.sides = rung.sides;
  options.tolerance = rung.tolerance, options.accept = rung.accept;
  return options;
}

MeshedScene meshed_with_own_steps(const fem::Scene& scene, const Rung& rung) {
  MeshedScene meshed{on_mesh(scene, rung), fem::pressing_parts(scene.load, rung.steps)};
  meshed.scene.load.indentation_steps = scene.load.indentation_steps * meshed.parts;
  return meshed;
}

GapSweepOptions mesh_options(const Rung& rung, bool nodes) {
  GapSweepOptions options;
  options.tolerance = rung.tolerance, options.accept = rung.accept;
  options.nodes = nodes;
  return options;
}

GapSweepSolver mesh_solver(Executor& executor, const Rung& rung, bool nodes, bool force_error) {
  GapSweepOptions options = mesh_options(rung, nodes);
  options.force_error = force_error;
  return {executor, rung.precision, options};
}

void finish_on_mesh(const GapSweepSolver& mesh, std::span<const fem::Scene> scenes, const Rung& rung,
                    std::vector<fem::ContactSolution>& answers) {
  std::vector<fem::Scene> modelled;
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (every_step_converged(answers[i]) || scenes[i].sensor.poisson == 0.5) continue;  // which no mesh takes
    others.push_back(i);
    modelled.push_back(meshed_with_own_steps(scenes[i], rung).scene);
  }
  std::vector<fem::ContactSolution> meshed = mesh.solve(modelled);
  for (std::size_t k = 0; k < others.size(); ++k) {
    const fem::Load& load = scenes[others[k]].load;
    keep_own_steps(meshed[k], load, fem::pressing_parts(load, rung.steps));
    if (every_step_converged(meshed[k])) answers[others[k]] = std::move(meshed[k]);
  }
}

std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes) {
  if (!rung.patch()) {
    std::vector<fem::Scene> modelled;
    for (const fem::Scene& scene : scenes) modelled.push_back(on_mesh(scene, rung));
    return mesh_solver(executor, rung, nodes).solve(modelled);
  }
  std::vector<fem::ContactSolution> answers = on_patches(executor, scenes, rung);
  finish_on_mesh(mesh_solver(executor, rung, nodes), scenes, rung, answers);
  return answers;
}

void make_tables(Executor& executor, std::size_t count, const std::function<void(std::size_t)>& make) {
  std::mutex mutex;
  std::size_t made = 0;
  std::optional<BusyMessage> busy;
  const auto say = [&] { busy.emplace(executor.device(), fmt::format("tables of sensors, {} of {}", made, count)); };
  say();
  side_by_side(count, executor.threads(), [&](std::size_t k) {
    make(k);
    const std::lock_guard lock(mutex);
    if (++made < count) say();
  });
}

fem::SensorFamily sensor_family(Executor& executor, const fem::SensorRange& range, bool sides) {
  const std::vector<double> poissons = fem::SensorFamily::node_poissons(range);
  std::vector<std::optional<fem::FamilyNode>> made(poissons.size());
  make_tables(executor, poissons.size(),
              [&](std::size_t k) { made[k] = fem::SensorFamily::node(range, poissons[k], sides); });
  std::vector<fem::FamilyNode> nodes;
  nodes.reserve(made.size());
  for (auto& node : made) nodes.push_back(std::move(*node));
  return {range, nodes};
}

std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, const fem::SensorFamily& family,
                                                std::span<const fem::Scene> scenes, const Rung& rung) {
  if (rung.exact) return solve_on_rung(executor, scenes, rung);
  if (rung.precision == Precision::fp32)
    return solve_patch_contact(PatchContact<float>(executor, family, patch_options(rung)), scenes);
  return solve_patch_contact(PatchContact<double>(executor, family, patch_options(rung)), scenes);
}

}  // namespace tactel::host
