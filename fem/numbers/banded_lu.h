// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace tactel::fem {

/// Right-hand sides in columns: [rows, right-hand sides].
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// LU factorization with row exchanges of a banded matrix, in place (Golub and Van Loan, Matrix Computations,
/// section 4.3.3).
class BandedLu {
 public:
  /// A zero matrix [size, size] with `band` diagonals on either side of the main one.
  BandedLu(int size, int band);

  double& entry(int row, int column) { return row_[place(row, column)]; }

  /// Factors the matrix and overwrites its entries. Returns false where a pivot is zero to rounding: the matrix
  /// is singular.
  bool factor();

  /// Replaces the right-hand sides [size, k] by the solutions.
  void solve(Eigen::Ref<RowMatrix> right_side) const;

 private:
  std::size_t place(int row, int column) const {
    return std::size_t(row) * stride_ + std::size_t(column - row + band_);
  }
  int choose_pivot(int column, int last) const;
  void exchange(int row, int other);

  int size_, band_;
  std::size_t stride_;
  std::vector<double>
      row_;  ///< [size, 3 band + 1]: row i holds columns i - band to i + 2 band; exchanges need the last band
  std::vector<int> end_;    ///< [size] one past the last column of row i that may be nonzero
  std::vector<int> pivot_;  ///< [size] the row that step k exchanged with row k
};

}  // namespace tactel::fem
