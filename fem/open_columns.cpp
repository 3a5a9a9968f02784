#include "fem/open_columns.h"

namespace tactel::fem {
namespace {

// Block (row_column, column_column) of K, dense.
Eigen::MatrixXd dense_block(const Eigen::SparseMatrix<double>& stiffness, const ColumnOrder& order, int row_column, int column) {
  const int row0 = order.first[row_column], row1 = order.first[row_column + 1];
  const int column0 = order.first[column], column1 = order.first[column + 1];
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(row1 - row0, column1 - column0);
  for (int j = column0; j < column1; ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(stiffness, order.dof[j]); entry; ++entry) {
      const int i = order.place[entry.row()];
      if (i >= row0 && i < row1) block(i - row0, j - column0) = entry.value();
    }
  }
  return block;
}

}  // namespace

OpenColumns::OpenColumns(const Eigen::SparseMatrix<double>& stiffness, const ColumnOrder& order, From from)
    : order_(order), from_(from), reduced_(order.columns()), factored_(order.columns()), link_(order.columns()) {
  for (int step = 0; step < order.columns(); ++step) {
    const int column = from == From::left ? step : order.columns() - 1 - step;
    reduced_[column] = dense_block(stiffness, order, column, column);
    if (step > 0) {
      const Eigen::MatrixXd coupling = dense_block(stiffness, order, outer(column), column);
      link_[column] = factored_[outer(column)].solve(coupling);
      reduced_[column].noalias() -= coupling.transpose() * link_[column];
    }
    factored_[column].compute(reduced_[column]);
  }
}

Eigen::Block<RowMatrix> OpenColumns::rows(RowMatrix& all, int column) const {
  return all.block(order_.first[column], 0, order_.first[column + 1] - order_.first[column], all.cols());
}

void OpenColumns::eliminate(int column, RowMatrix& right_side) const {
  const int inwards = from_ == From::left ? 1 : -1;
  for (int c = outermost(); c != column; c += inwards) {
    rows(right_side, c + inwards) -= link_[c + inwards].transpose() * rows(right_side, c);
  }
}

void OpenColumns::substitute(int column, RowMatrix& solution) const {
  for (int c = column; c != outermost(); c = outer(c)) {
    auto outside = rows(solution, outer(c));
    if (!outside.isZero(0)) outside = factored_[outer(c)].solve(outside).eval();
    outside.noalias() -= link_[c] * rows(solution, c);
  }
}

}  // namespace tactel::fem
