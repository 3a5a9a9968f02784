// SPDX-License-Identifier: Apache-2.0
#include "host/answers/derivatives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/layer/patch_derivatives.h"
#include "host/scenes/ladder.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr int most_columns = 321;        ///< the exact solver takes seconds there
constexpr double most_pairs = 1e6;       ///< of a load step and a listed load: 0.4 GB of derivatives
constexpr double another_answer = 0.02;  ///< of S: more than the loosest tolerance of a rung leaves

[[noreturn]] void refuse(const SolveOutcome& outcome, const std::string& allowed) {
  throw ConfigError("command line", "--derivatives", model_name(outcome), allowed);
}

/// Every listed load is a parameter: as many derivatives as load steps.
void check_pairs(const fem::Load& load, std::size_t steps) {
  const std::size_t listed = load.indentation.size() + load.normal_force.size() + load.tangential.size();
  if (static_cast<double>(listed) * static_cast<double>(steps) <= most_pairs) return;
  throw ConfigError("command line", "--derivatives", fmt::format("{} load steps, {} of them listed", steps, listed),
                    "left out for a path with more than 1000000 pairs of a load step and a listed load");
}

fem::SceneDerivatives of_patch(const fem::Scene& scene, const Rung& rung) {
  const fem::LayerModel model = rung.sides ? fem::layer_model(scene.sensor) : fem::endless_layer(scene.sensor);
  fem::LayerDerivatives layer(model);
  return fem::patch_derivatives(model, layer, scene, {.elements = rung.elements, .pressing_increments = rung.steps});
}

fem::SceneDerivatives exact_path(const fem::Scene& scene, const SolveOutcome& outcome) {
  const Rung* rung = !outcome.rung.empty() ? &rung_named(outcome.rung) : nullptr;
  if (rung && rung->exact && outcome.on_patch())
    refuse(outcome, "a patch or a mesh, such as --rung patch-24, instead of the reference of patches");
  if (outcome.solution.linear_elements)
    refuse(outcome, "a mesh, or a contact that is narrower beside the rubber's thickness");
  if (outcome.on_patch()) return of_patch(scene, rung ? *rung : usual_patch());
  const fem::Sensor& sensor = outcome.scene.sensor;
  if (sensor.columns > most_columns) refuse(outcome, fmt::format("a mesh of at most {} columns", most_columns));
  // A scene of a patch that a mesh answered has the patch's increments.
  const bool from_patch = rung ? rung->patch() : scene.model == fem::SurfaceModel::patch;
  const Rung& own = rung ? *rung : usual_patch();
  return fem::mesh_derivatives(outcome.scene, from_patch ? fem::pressing_parts(scene.load, own.steps) : 1);
}

double difference_of_S(const fem::ContactSolution& solution, const std::vector<fem::PathAnswer>& exact) {
  double most = 0;
  for (std::size_t k = 0; k < exact.size(); ++k)
    most = std::max(most, std::abs(solution.steps[k].slip_index.value_or(0) - exact[k].S.value_or(0)));
  return most;
}

}  // namespace

ContactDerivatives derivatives(const fem::Scene& scene, const SolveOutcome& outcome) {
  check_pairs(scene.load, outcome.solution.steps.size());
  const auto path = [&] {
    try {
      return exact_path(scene, outcome);
    } catch (const fem::PathError& error) {
      refuse(outcome, std::string("a scene whose exact path is found: ") + error.what());
    }
  }();
  ContactDerivatives result{path.parameters, path.missing, {}, {}, 0};
  const std::vector<fem::PathAnswer>& exact = path.path.answers();
  if (exact.size() != outcome.solution.steps.size()) refuse(outcome, "a scene whose exact path has as many steps");
  result.answer_difference = difference_of_S(outcome.solution, exact);
  if (!(result.answer_difference <= another_answer))
    refuse(outcome,
           fmt::format("a contact with one solution: S of the exact path is off by {:.2g}", result.answer_difference));
  for (const fem::PathDirection& direction : path.directions) result.by.push_back(path.path.forward(direction));
  for (const fem::PathAnswer& answer : exact)
    result.distance_to_switch.push_back(std::max(0.0, answer.distance_to_switch));
  return result;
}

}  // namespace tactel::host
