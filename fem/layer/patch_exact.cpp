#include "fem/layer/patch_exact.h"

#include "fem/gap_condensed.h"
#include "fem/layer/patch_compliance.h"

namespace tactel::fem {

ContactSolution solve_in_increments(const Condensation& condensation, const Scene& scene, int pressing_increments,
                                    const GapReferenceOptions& options) {
  const int asked = scene.load.indentation_steps, parts = (pressing_increments + asked - 1) / asked;
  Scene divided = scene;
  divided.load.indentation_steps = asked * parts;
  const int pressing_steps = load_path(divided.load).indentation_steps;
  ContactSolution solution = GapCondensed(condensation, options).solve(divided);
  std::vector<ContactStep> kept;
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    const int step = static_cast<int>(k);
    if (step >= pressing_steps || (step + 1) % parts == 0) kept.push_back(std::move(solution.steps[k]));
  }
  solution.steps = std::move(kept);
  return solution;
}

ContactSolution solve_patch_exactly(const LayerModel& model, const Patch& patch, const Scene& scene,
                                    int pressing_increments, const GapReferenceOptions& options) {
  return solve_in_increments(patch_condensation(model, patch), scene, pressing_increments, options);
}

}  // namespace tactel::fem
