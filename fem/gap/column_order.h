// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Sparse>
#include <vector>

#include "fem/mesh/mesh.h"

namespace tactel::fem {

/// Order of the free unknowns of the block: by mesh column, and through the thickness in each. K is then banded
/// and block tridiagonal. The mid-side nodes of q8 belong to the column on their right.
struct ColumnOrder {
  std::vector<int> dof;    ///< [unknowns] degree of freedom of the mesh
  std::vector<int> place;  ///< [2 nodes] index of that degree of freedom among the unknowns; -1 if clamped
  std::vector<int> first;  ///< [columns + 1] first unknown of each column
  int columns() const { return static_cast<int>(first.size()) - 1; }
  int size() const { return static_cast<int>(dof.size()); }
};

ColumnOrder order_by_column(const Mesh& mesh);

/// Returns K of the free unknowns in their order: [unknowns, unknowns] from [2 nodes, 2 nodes].
Eigen::SparseMatrix<double> ordered(const Eigen::SparseMatrix<double>& stiffness, const ColumnOrder& order);

/// Returns the number of diagonals on either side of the main one. They hold K, the dense blocks left by open
/// columns, and the combined rows of slipping nodes.
int band_of(const Eigen::SparseMatrix<double>& stiffness, const ColumnOrder& order);

}  // namespace tactel::fem
