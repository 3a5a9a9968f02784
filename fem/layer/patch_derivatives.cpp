// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_derivatives.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fem/layer/patch_path.h"
#include "fem/layer/rigid_contact.h"
#include "fem/shape_derivatives.h"

namespace tactel::fem {
namespace {

PathDirection direction(RubberChange change) {
  return {.compliance = std::move(change.compliance), .tactel_stress = std::move(change.tactel_stress)};
}

void add_position(const LayerDerivatives& layer, const Scene& scene, const Patch& patch, SceneDerivatives& result) {
  const SceneParameter position{"indenter.position", scene.indenter.position, "mm"};
  const bool flat = std::holds_alternative<Flat>(scene.indenter.shape);
  const auto* shape = std::get_if<Flat>(&scene.indenter.shape);
  if (!patch.reaches_left && !patch.reaches_right) {
    result.add(position, direction(layer.by_ends(patch, 1, 1)));
  } else if (!flat) {
    result.add(position, {.height = -profile_slopes(scene.indenter, places(patch))});
  } else {
    result.missing.push_back({position.name, "the flat reaches an end of the sensor"});
  }
  if (!shape || !shape->half_width) return;
  if (patch.edge_left && patch.edge_right) {
    const double x = scene.indenter.position, half = *shape->half_width;
    result.add({"indenter.half_width", half, "mm"},
               direction(layer.by_ends(patch, (patch.left - x) / half, (patch.right - x) / half)));
  } else {
    result.missing.push_back({"indenter.half_width", "an edge of the flat lies beyond the sensor"});
  }
}

}  // namespace

PatchOptions exact_sweeps(PatchOptions options) {
  options.tolerance = 1e-13;
  options.accept = 1e-9;
  options.most_sweeps = 20000;
  return options;
}

SceneDerivatives patch_derivatives(const LayerModel& model, LayerDerivatives& layer, const Scene& scene,
                                   const PatchTrace& trace, const PatchOptions& options) {
  const Condensation rubber = patch_condensation(model, trace.patch);
  Scene own = scene;
  own.indenter = with_hull(scene.indenter);
  SceneDerivatives result{PathDerivatives({.compliance = rubber.compliance,
                                           .tactel_stress = rubber.tactel_stress,
                                           .height = profile_heights(own.indenter, rubber.surface_x),
                                           .mu = std::min(scene.friction, largest_friction),
                                           .young = scene.sensor.young,
                                           .increments = trace.increments}),
                          {},
                          {},
                          {}};
  require_solution(result.path);
  const auto targets = [&](const Load& load) {
    std::vector<LoadStep> steps;
    for (const PatchStep& step : patch_steps(load_path(load), load, options.increments())) steps.push_back(step.target);
    return steps;
  };
  add_common_parameters(own, rubber.surface_x, targets, result);
  add_position(layer, own, trace.patch, result);
  if (LayerDerivatives::has_poisson(model))
    result.add({"sensor.poisson", scene.sensor.poisson, ""}, direction(layer.by_poisson(trace.patch)));
  else
    result.missing.push_back({"sensor.poisson", "its central difference, 0.001 on both sides, leaves 0 to 0.49999"});
  result.add({"sensor.thickness", scene.sensor.thickness, "mm"}, direction(layer.by_thickness(trace.patch)));
  return result;
}

SceneDerivatives patch_derivatives(const LayerModel& model, LayerDerivatives& layer, const Scene& scene,
                                   const PatchOptions& options) {
  PatchTrace trace;
  const ContactSolution solution = PatchSolver(model, exact_sweeps(options)).solve(scene, &trace);
  const auto failed = std::ranges::find_if(solution.steps, [](const ContactStep& step) { return !step.converged; });
  if (failed != solution.steps.end())
    throw PathError("the sweeps did not solve step " + std::to_string(failed - solution.steps.begin() + 1));
  return patch_derivatives(model, layer, scene, trace, options);
}

}  // namespace tactel::fem
