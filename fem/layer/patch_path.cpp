// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_path.h"

#include "fem/gap/load_stepping.h"

namespace tactel::fem {

std::vector<PatchStep> patch_steps(const LoadPath& path, const Load& load, int pressing_increments) {
  const int parts = pressing_parts(load, pressing_increments);
  std::vector<PatchStep> steps;
  steps.reserve(path.steps.size() +
                static_cast<std::size_t>(path.indentation_steps) * static_cast<std::size_t>(parts - 1));
  LoadStep from = path.steps.front();
  from.normal = from.tangential = 0;
  for (std::size_t i = 0; i < path.steps.size(); ++i) {
    const LoadStep& to = path.steps[i];
    const bool held = to.normal == from.normal && to.tangential == from.tangential;
    const int count = static_cast<int>(i) < path.indentation_steps && !held ? parts : 1;
    for (int k = 1; k < count; ++k) {
      LoadStep part = to;
      part.normal = from.normal + (to.normal - from.normal) * k / count;
      part.tangential = from.tangential + (to.tangential - from.tangential) * k / count;
      steps.push_back({part, false});
    }
    steps.push_back({to, true});
    from = to;
  }
  return steps;
}

}  // namespace tactel::fem
