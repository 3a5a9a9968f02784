// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <optional>
#include <vector>

#include "fem/gap/gap_system.h"
#include "fem/gap/open_columns.h"
#include "fem/mesh/mesh.h"

namespace tactel::fem {

/// The whole block as a GapSystem. A state holds the displacements of all nodes [2 nodes, k] mm, with f = K u.
/// Unknowns are eliminated from both ends of the block towards the columns in contact. The eliminated ends are
/// cached, so that an object serves one thread only.
class GapBlock : public GapSystem {
 public:
  /// `stiffness` [2 nodes, 2 nodes] is unclamped, as stiffness() returns it. Throws std::invalid_argument where
  /// it resists rigid translations by more than rounding.
  GapBlock(Mesh mesh, const Eigen::SparseMatrix<double>& stiffness);

  const Mesh& mesh() const { return mesh_; }
  int columns() const override { return int(mesh_.surface.size()); }
  Eigen::Index state_size() const override { return mesh_.node.size(); }

  /// Factors in double and refines to extended precision.
  std::optional<Extended> solve(const std::vector<Trial>& trial, double mu, const Extended& right_side) override;

  Extended surface_displacement(const Extended& displacement) const override;
  Extended surface_force(const Extended& displacement) const override;  ///< K u
  Extended base_force(const Extended& displacement) const override;     ///< -K u

  /// Returns the mean of K's diagonal at the surface nodes.
  double typical_stiffness() const override;

 private:
  int unknown_of(int column) const { return order_.place[2 * mesh_.surface[column]]; }  ///< its surface node's x
  class System;                                                                         ///< one trial's factored system

  long double force(int dof, const Extended& displacement, Eigen::Index side) const;
  Extended forces(const std::vector<int>& nodes, const Extended& displacement) const;

  Mesh mesh_;
  Eigen::SparseMatrix<double> stiffness_;
  Eigen::SparseMatrix<long double, Eigen::RowMajor> exact_stiffness_;  ///< resists rigid translations by at most 1e-19
  ColumnOrder order_;
  int band_;                  ///< diagonals of the system on either side of the main one
  OpenColumns left_, right_;  ///< extended as trials need more columns
};

}  // namespace tactel::fem
