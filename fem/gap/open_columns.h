// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <vector>

#include "fem/gap/column_order.h"
#include "fem/numbers/banded_lu.h"

namespace tactel::fem {

/// Block Cholesky elimination of mesh columns without contact, from one end of the block inwards. The remainder
/// does not depend on the contact, so each column of a block is eliminated once. Each iteration of the active-set
/// method factors only the columns between the outermost nodes in contact.
class OpenColumns {
 public:
  enum class From { left, right };
  OpenColumns(const Eigen::SparseMatrix<double>& stiffness, ColumnOrder order, From from);

  /// Returns the diagonal block of `column` after the elimination of all columns outside of it: [n, n], n
  /// unknowns of that column.
  Eigen::MatrixXd reduced_block(int column);

  /// Eliminates the columns outside of `column` from right-hand sides [unknowns, k].
  void eliminate(int column, RowMatrix& right_side);

  /// Computes the columns outside of `column` from the solution in it.
  void substitute(int column, RowMatrix& solution);

 private:
  int outermost() const { return from_ == From::left ? 0 : order_.columns() - 1; }
  int outwards() const { return from_ == From::left ? -1 : 1; }
  void reach(int column);
  Eigen::MatrixXd reduce(int column) const;
  Eigen::Block<RowMatrix> rows(RowMatrix& all, int column) const;
  Eigen::SparseMatrix<double> coupling(int column) const;

  Eigen::SparseMatrix<double> stiffness_;  ///< [unknowns, unknowns] in their order, N/mm per mm
  ColumnOrder order_;
  From from_;
  int eliminated_ = 0;  ///< number of columns factored so far, from the outermost on
  std::vector<Eigen::LLT<Eigen::MatrixXd>>
      factor_;  ///< [columns] of D_c = K_cc - K_co D_o^-1 K_oc, o next outwards of c
};

}  // namespace tactel::fem
