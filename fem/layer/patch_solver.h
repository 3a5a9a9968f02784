// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/contact_solution.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch_compliance.h"
#include "fem/layer/patch_contact.h"
#include "fem/layer/patch_search.h"

namespace tactel::fem {

/// Contact on a scene's own patch, fp64, one scene at a time: the twin of the patch kernel. It shares the algorithm
/// with the kernel, but no code. Block Gauss-Seidel over the elements, left to right, relaxed (patch_laws.h); the
/// certificate comes from the final forces alone. Where the surface is penetrated beyond an end of the patch, the patch
/// grows on that side, and the scene is solved again. Keeps a reference to the model.
class PatchSolver {
 public:
  explicit PatchSolver(const LayerModel& model, const PatchOptions& options = {});

  /// Solves a scene on the model's sensor; E and the mesh may differ. Nodes of the answer are the elements of the patch
  /// (surface_x: their middles). The base is one node, which bears the sums of the forces. Throws ValueError for an
  /// invalid scene, std::invalid_argument for another sensor.
  /// Where `last` is given it takes the last patch.
  ContactSolution solve(const Scene& scene, Patch* last = nullptr) const;

  /// The same on a given patch, which does not grow.
  ContactSolution solve_on(const Patch& patch, const Scene& scene) const;

  const PatchOptions& options() const { return options_; }

 private:
  const LayerModel& model_;
  PatchOptions options_;
};

/// Returns the patch grown by the elements beyond its ends that are penetrated at most, and half an element more.
/// `beyond_left` and `beyond_right` are numbers of elements, 0 to rows_beyond.
Patch grown(const Patch& patch, int beyond_left, int beyond_right, const PatchLimits& limits);

}  // namespace tactel::fem
