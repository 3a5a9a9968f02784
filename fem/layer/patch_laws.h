// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/layer/patch_compliance.h"

namespace tactel::fem {

/// Relaxation of the sweeps: the share of the way to the solution of an element's own laws that an update takes.
/// Below 1 from the first sweep on: undamped sweeps go round in circles where friction is high.
inline constexpr double relaxation = 0.85;

/// The laws of all elements, scaled once so that an update has neither division nor diagonal term. With forces over
/// E (mm), pressure n and traction t:
///     n_i = max(0, press_i + sum_j (A_ij n_j + B_ij t_j)),           press_i = n_per_uy_i (depth - height_i)
///     t_i = clip(drag_i + sum_j (D_ij n_j + E_ij t_j), +- mu n_i),   drag_i = t_per_ux_i (u_x that a stick has)
/// where A_ii = E_ii = 1 - w with the relaxation w, and D_ii meets the new n_i.
struct PatchLaws {
  using Matrix = PatchCompliance::Matrix;
  Matrix A, B, D, E;                   ///< [elements, elements]
  Eigen::VectorXd n_per_uy, t_per_ux;  ///< [elements] w / compliance of an element to itself
};

PatchLaws patch_laws(const PatchCompliance& compliance, double w);

}  // namespace tactel::fem
