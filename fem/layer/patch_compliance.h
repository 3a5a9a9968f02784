// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

#include "fem/layer/layer_model.h"
#include "fem/layer/patch.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem {

/// Displacement at places by pressure n and traction t of a patch's elements; E = 1 MPa, mm/(N/mm).
struct PatchCompliance {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Matrix uy_by_n, uy_by_t, ux_by_n, ux_by_t;  ///< [places, elements]
};

/// Places beyond either end of a patch at which penetration is looked for, one element apart.
inline constexpr int rows_beyond = 3;

/// Returns the compliance at the elements -rows_beyond to elements + rows_beyond - 1 of the patch:
/// [elements + 2 rows_beyond, elements]; layer and free sides.
PatchCompliance patch_compliance(const LayerModel& model, const Patch& patch);

/// Returns the patch as the exact solver (fem/gap/gap_condensed.h) wants it: elements are its gap elements. The base is
/// one node, which bears the sums of the forces.
Condensation patch_condensation(const LayerModel& model, const Patch& patch);

/// The same for gap elements at any places [elements] mm, its compliance [2 elements, 2 elements] still to be filled.
Condensation without_compliance(const LayerModel& model, const Eigen::VectorXd& places);

}  // namespace tactel::fem
