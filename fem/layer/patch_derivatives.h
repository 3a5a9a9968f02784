// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/layer/layer_derivatives.h"
#include "fem/layer/patch_solver.h"
#include "fem/scene_derivatives.h"

namespace tactel::fem {

/// Sweeps that leave no error but rounding, with as many elements and increments as `options`.
PatchOptions exact_sweeps(PatchOptions options);

/// Returns the scene's path on a solved patch and the directions of its numbers. The elements stay where they are, but
/// for two numbers: with indenter.position they move along with the indenter, with the half_width of `flat` they
/// stretch. Throws PathError where the trace's statuses do not solve the contact.
SceneDerivatives patch_derivatives(const LayerModel& model, LayerDerivatives& layer, const Scene& scene,
                                   const PatchTrace& trace, const PatchOptions& options);

/// Solves a scene on its own patch by exact_sweeps(options) and returns its derivatives. Throws ValueError for an
/// invalid scene, and PathError where the sweeps do not converge.
SceneDerivatives patch_derivatives(const LayerModel& model, LayerDerivatives& layer, const Scene& scene,
                                   const PatchOptions& options = {});

}  // namespace tactel::fem
