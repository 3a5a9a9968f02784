// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_exact.h"

#include "fem/gap/gap_condensed.h"
#include "fem/layer/patch_compliance.h"

namespace tactel::fem {

ContactSolution solve_in_increments(const Condensation& condensation, const Scene& scene, int pressing_increments,
                                    const GapReferenceOptions& options) {
  const int parts = pressing_parts(scene.load, pressing_increments);
  Scene divided = scene;
  divided.load.indentation_steps *= parts;
  ContactSolution solution = GapCondensed(condensation, options).solve(divided);
  keep_own_steps(solution, scene.load, parts);
  return solution;
}

ContactSolution solve_patch_exactly(const LayerModel& model, const Patch& patch, const Scene& scene,
                                    int pressing_increments, const GapReferenceOptions& options) {
  ContactSolution solution = solve_in_increments(patch_condensation(model, patch), scene, pressing_increments, options);
  solution.surface_width = Eigen::VectorXd::Constant(patch.elements, patch.width());
  return solution;
}

}  // namespace tactel::fem
