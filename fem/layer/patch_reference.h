// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/contact_solution.h"
#include "fem/gap/load_stepping.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch.h"
#include "fem/layer/patch_contact.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem {

/// The judge of the patch solver's accuracy: many elements, finer towards edges of the indenter, many increments, and
/// the exact active-set solver (fem/gap/gap_condensed.h) in fp64. Near an end of the sensor the elements are nodes of a
/// graded mesh (end_mesh.h). A scene takes seconds. Keeps a reference to the model.
class PatchReference {
 public:
  explicit PatchReference(const LayerModel& model, const PatchOptions& options = {.elements = 240});

  /// Solves a scene; as PatchSolver::solve. Steps that the exact solver could not solve have converged = false: with mu
  /// above 1 near nu = 1/2 fewer elements may help.
  ContactSolution solve(const Scene& scene) const;

 private:
  const LayerModel& model_;
  PatchOptions options_;
};

/// Elements side by side, of any widths.
struct UnequalElements {
  Eigen::VectorXd middle, width;  ///< [elements] mm
};

/// Returns elements over a contact [left, right]: equal ones, or with the spacing of a cosine towards the sides that
/// are edges of the indenter.
UnequalElements graded_elements(Interval contact, bool edge_left, bool edge_right, int elements);

/// Returns the elements as the exact solver wants them; as patch_condensation. Their compliance is not symmetric.
Condensation elements_condensation(const LayerModel& model, const UnequalElements& elements);

}  // namespace tactel::fem
