#pragma once
#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <vector>

#include "fem/banded_lu.h"

namespace tactel::fem {

/// Free unknowns of the block, one mesh column after another and through the thickness in each, so that K is banded and block tridiagonal.
/// The mid-side nodes of q8 belong to the column on their right.
struct ColumnOrder {
  std::vector<int> dof;    ///< [unknowns] degree of freedom of the mesh
  std::vector<int> place;  ///< [2 nodes] where that degree of freedom stands among the unknowns; -1 if clamped
  std::vector<int> first;  ///< [columns + 1] first unknown of each column
  int columns() const { return int(first.size()) - 1; }
  int size() const { return int(dof.size()); }
};

/// Elimination of mesh columns without contact, from one end of the block inwards. What it leaves does not depend on the contact, so it
/// is done once a block; only columns between the outermost nodes in contact are factored anew in each status iteration.
class OpenColumns {
 public:
  enum class From { left, right };
  OpenColumns(const Eigen::SparseMatrix<double>& stiffness, const ColumnOrder& order, From from);

  /// Diagonal block of `column` after the elimination of all columns outside of it: [n, n], n unknowns of that column.
  const Eigen::MatrixXd& reduced_block(int column) const { return reduced_[column]; }

  /// Right sides [unknowns, k]: eliminates the columns outside of `column`.
  void eliminate(int column, RowMatrix& right_side) const;

  /// The columns outside of `column` follow from the solution in it.
  void substitute(int column, RowMatrix& solution) const;

 private:
  int outer(int column) const { return from_ == From::left ? column - 1 : column + 1; }
  int outermost() const { return from_ == From::left ? 0 : order_.columns() - 1; }
  Eigen::Block<RowMatrix> rows(RowMatrix& all, int column) const;

  ColumnOrder order_;
  From from_;
  std::vector<Eigen::MatrixXd> reduced_;               ///< [columns] D_c = K_cc - K_co D_o^-1 K_oc, o the next column outwards
  std::vector<Eigen::LLT<Eigen::MatrixXd>> factored_;  ///< [columns] of D_c
  std::vector<Eigen::MatrixXd> link_;                  ///< [columns] D_o^-1 K_oc: the outer column follows as -link u_c
};

}  // namespace tactel::fem
