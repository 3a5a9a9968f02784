// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/open_columns.h"

#include <cstdlib>

namespace tactel::fem {

OpenColumns::OpenColumns(const Eigen::SparseMatrix<double>& stiffness, ColumnOrder order, From from)
    : stiffness_(stiffness), order_(std::move(order)), from_(from), factor_(order_.columns()) {}

Eigen::Block<RowMatrix> OpenColumns::rows(RowMatrix& all, int column) const {
  return all.block(order_.first[column], 0, order_.first[column + 1] - order_.first[column], all.cols());
}

// K_oc: rows of the column outwards of `column`, columns of `column` itself.
Eigen::SparseMatrix<double> OpenColumns::coupling(int column) const {
  const int outer = column + outwards();
  return stiffness_.block(order_.first[outer], order_.first[column], order_.first[outer + 1] - order_.first[outer],
                          order_.first[column + 1] - order_.first[column]);
}

Eigen::MatrixXd OpenColumns::reduced_block(int column) {
  reach(column);
  return reduce(column);
}

Eigen::MatrixXd OpenColumns::reduce(int column) const {
  const int first = order_.first[column], count = order_.first[column + 1] - first;
  Eigen::MatrixXd reduced = stiffness_.block(first, first, count, count);
  if (column == outermost()) return reduced;
  const Eigen::SparseMatrix<double> link = coupling(column);
  const Eigen::MatrixXd followed = factor_[column + outwards()].solve(Eigen::MatrixXd(link));
  reduced.noalias() -= link.transpose() * followed;
  return reduced;
}

// Factors every column outside of `column`.
void OpenColumns::reach(int column) {
  while (eliminated_ < std::abs(column - outermost())) {
    const int next = outermost() - outwards() * eliminated_;
    factor_[next].compute(reduce(next));
    ++eliminated_;
  }
}

void OpenColumns::eliminate(int column, RowMatrix& right_side) {
  reach(column);
  for (int c = outermost(); c != column; c -= outwards()) {
    auto outside = rows(right_side, c);
    if (outside.isZero(0)) continue;  // no load there, the usual case
    rows(right_side, c - outwards()).noalias() -= coupling(c - outwards()).transpose() * factor_[c].solve(outside);
  }
}

void OpenColumns::substitute(int column, RowMatrix& solution) {
  reach(column);
  for (int c = column; c != outermost(); c += outwards()) {
    auto outside = rows(solution, c + outwards());
    outside.noalias() -= coupling(c) * rows(solution, c);
    outside = factor_[c + outwards()].solve(outside).eval();
  }
}

}  // namespace tactel::fem
