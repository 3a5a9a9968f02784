// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/clamped_block.h"

#include <utility>

#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem {
namespace {

// Loads side by side in a row, so that each entry of the factor, fetched once, serves all of them. The width is known
// at build time, so that a row stays in vector registers.
using Loads = Eigen::Matrix<double, Eigen::Dynamic, ClampedBlock::loads_at_a_time, Eigen::RowMajor>;

/// x := L^-T L^-1 x with L by columns, the diagonal first in each.
void solve_in_place(const Eigen::SparseMatrix<double>& factor, Loads& x) {
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  for (Eigen::Index j = 0; j < factor.cols(); ++j) {
    Entry entry(factor, j);
    x.row(j) /= entry.value();
    for (++entry; entry; ++entry) x.row(entry.row()) -= entry.value() * x.row(j);
  }
  for (Eigen::Index j = factor.cols(); j-- > 0;) {
    Entry entry(factor, j);
    const double diagonal = entry.value();
    for (++entry; entry; ++entry) x.row(j) -= entry.value() * x.row(entry.row());
    x.row(j) /= diagonal;
  }
}

/// Number of each unknown among the chosen ones, -1 for others, [2 nodes].
std::vector<int> places(const std::vector<int>& chosen, Eigen::Index unknowns) {
  std::vector<int> place(static_cast<std::size_t>(unknowns), -1);
  for (std::size_t i = 0; i < chosen.size(); ++i) place[static_cast<std::size_t>(chosen[i])] = static_cast<int>(i);
  return place;
}

Eigen::SparseMatrix<double> principal_part(const Eigen::SparseMatrix<double>& matrix, const std::vector<int>& chosen) {
  const std::vector<int> place = places(chosen, matrix.cols());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(matrix.nonZeros()));
  for (std::size_t j = 0; j < chosen.size(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator e(matrix, chosen[j]); e; ++e)
      if (const int i = place[static_cast<std::size_t>(e.row())]; i >= 0)
        entries.emplace_back(i, static_cast<int>(j), e.value());
  const auto size = static_cast<Eigen::Index>(chosen.size());
  Eigen::SparseMatrix<double> part(size, size);
  part.setFromTriplets(entries.begin(), entries.end());
  return part;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> rows_of(const Eigen::SparseMatrix<double>& matrix,
                                                     const std::vector<int>& chosen) {
  const Eigen::SparseMatrix<double, Eigen::RowMajor> by_rows = matrix;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows(static_cast<Eigen::Index>(chosen.size()), matrix.cols());
  for (std::size_t i = 0; i < chosen.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = by_rows.row(chosen[i]);
  return rows;
}

}  // namespace

ClampedBlock::ClampedBlock(Mesh mesh, const Sensor& sensor) : mesh_(std::move(mesh)) {
  const Eigen::SparseMatrix<double> whole = stiffness(mesh_, sensor);
  const std::vector<int> clamped = unknowns_of(mesh_.base), place = places(clamped, whole.rows());
  std::vector<int> free;
  for (int i = 0; i < whole.rows(); ++i)
    if (place[static_cast<std::size_t>(i)] < 0) free.push_back(i);
  base_rows_ = rows_of(whole, clamped);
  factor_.compute(principal_part(whole, free));
  if (factor_.info() != Eigen::Success)
    throw ValueError(
        "sensor.poisson", number_text(sensor.poisson),
        "further from 0.5, or the block less flat: its stiffness has no Cholesky factor in double precision");
  order_.resize(free.size());
  for (std::size_t i = 0; i < free.size(); ++i)
    order_[static_cast<std::size_t>(factor_.permutationP().indices()[static_cast<Eigen::Index>(i)])] = free[i];
}

Eigen::MatrixXd ClampedBlock::displacement(const Eigen::MatrixXd& load) const {
  Eigen::MatrixXd displacement = Eigen::MatrixXd::Zero(load.rows(), load.cols());
  for (Eigen::Index first = 0; first < load.cols(); first += loads_at_a_time) {
    const Eigen::Index count = std::min<Eigen::Index>(loads_at_a_time, load.cols() - first);
    Loads x = Loads::Zero(static_cast<Eigen::Index>(order_.size()), loads_at_a_time);
    for (std::size_t i = 0; i < order_.size(); ++i)
      x.row(static_cast<Eigen::Index>(i)).head(count) = load.row(order_[i]).segment(first, count);
    solve_in_place(factor_.matrixL().nestedExpression(), x);
    for (std::size_t i = 0; i < order_.size(); ++i)
      displacement.row(order_[i]).segment(first, count) = x.row(static_cast<Eigen::Index>(i)).head(count);
  }
  return displacement;
}

Eigen::MatrixXd ClampedBlock::base_force(const Eigen::MatrixXd& displacement) const {
  return -(base_rows_ * displacement);
}

}  // namespace tactel::fem
