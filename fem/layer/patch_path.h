// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "fem/scenes/scene.h"

namespace tactel::fem {

/// One increment of a path with more pressing increments than the load has.
struct PatchStep {
  LoadStep target;
  bool asked = true;  ///< the load has it, and the answer a step for it
};

/// Returns the path's increments, those of the indentation divided so that each target takes at least
/// `pressing_increments` equal ones.
std::vector<PatchStep> patch_steps(const LoadPath& path, const Load& load, int pressing_increments);

}  // namespace tactel::fem
