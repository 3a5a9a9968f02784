// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/contact_solution.h"
#include "fem/gap/load_stepping.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem {

/// Solves a scene exactly, by the active-set method (fem/gap/gap_condensed.h), on the elements of a patch: for scenes
/// that sweeps could not solve. `pressing_increments` is the least number of increments to each pressing target; the
/// answer has the load's own steps.
ContactSolution solve_patch_exactly(const LayerModel& model, const Patch& patch, const Scene& scene,
                                    int pressing_increments, const GapReferenceOptions& options = {});

/// The same on any condensation.
ContactSolution solve_in_increments(const Condensation& condensation, const Scene& scene, int pressing_increments,
                                    const GapReferenceOptions& options = {});

}  // namespace tactel::fem
