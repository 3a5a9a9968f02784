// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/gap_block.h"
#include "fem/gap/load_stepping.h"

namespace tactel::fem {

/// Solves contact on the full finite element mesh, fp64: the reference of the batched solver. Gap elements are
/// open, sticking or slipping. Each iteration of the active-set method solves the whole block, without
/// condensation, with their conditions as constraints, until no status changes.
ContactSolution solve_gap_reference(const Scene& scene, const GapReferenceOptions& options = {});

/// The same for many scenes on one sensor. Mesh, stiffness and the factors that do not depend on the contact are
/// kept.
class GapReference {
 public:
  explicit GapReference(const Sensor& sensor, const GapReferenceOptions& options = {});

  /// Throws std::invalid_argument where the scene's sensor differs.
  ContactSolution solve(const Scene& scene);

 private:
  Eigen::VectorXd tactel_stress(const Extended& displacement, const Eigen::VectorXd& base_force) const;

  Sensor sensor_;
  GapReferenceOptions options_;
  GapBlock block_;
  Eigen::VectorXd surface_x_, base_x_, tactel_x_;   ///< mm
  Eigen::MatrixXd stress_of_reaction_;              ///< [tactels, base nodes] 1/mm, or empty
  Eigen::SparseMatrix<double> stress_of_elements_;  ///< [2 tactels, 2 nodes] MPa/mm, or empty
};

}  // namespace tactel::fem
