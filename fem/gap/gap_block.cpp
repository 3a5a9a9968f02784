// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/gap_block.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactel::fem {
namespace {

// A factorization in double leaves errors of cond(K) rounding errors, 1e-8 on fine meshes near nu = 0.5; each further
// pass takes as many digits again, until displacements are good to this, far below what double resolves.
constexpr double refined = 1e-19;
constexpr int most_passes = 6;

// Rounding of K's entries leaves rigid translations with forces of 1e-16 K u, u the motion of the whole block: 1e-9 of
// the contact's forces on fine meshes near nu = 0.5. Here each row's sum over the nodes, x and y apart, is brought to 0
// by the node's own entries.
Eigen::SparseMatrix<long double, Eigen::RowMajor> without_rigid_forces(const Eigen::SparseMatrix<double>& stiffness) {
  Eigen::SparseMatrix<long double, Eigen::RowMajor> exact = stiffness.cast<long double>();
  for (int row = 0; row < exact.rows(); ++row) {
    long double sum[2] = {0, 0}, largest = 0;  // sums over the columns for x and for y
    for (decltype(exact)::InnerIterator entry(exact, row); entry; ++entry) {
      sum[entry.col() % 2] += entry.value();
      largest = std::max(largest, std::abs(entry.value()));
    }
    for (int direction : {0, 1}) {
      if (!(std::abs(sum[direction]) <= 1e-8L * largest)) {
        throw std::invalid_argument("GapBlock: the stiffness resists a rigid translation");
      }
      exact.coeffRef(row, row / 2 * 2 + direction) -= sum[direction];
    }
  }
  return exact;
}

}  // namespace

class GapBlock::System {
 public:
  System(GapBlock& block, const std::vector<Trial>& trial, double mu)
      : block_(block),
        trial_(trial),
        mu_(mu),
        first_(first_touching()),
        last_(last_touching()),
        begin_(block.order_.first[first_]),
        left_end_(block.left_.reduced_block(first_)),
        right_end_(block.right_.reduced_block(last_)),
        matrix_(block.order_.first[last_ + 1] - begin_, block.band_),
        prescribed_(block.order_.size(), 0) {
    assemble();
    regular_ = matrix_.factor();
  }

  bool regular() const { return regular_; }

  /// Right sides of all rows [unknowns, k], as the class comment of GapBlock gives them, become displacements.
  void solve(RowMatrix& right_side) const {
    const RowMatrix given = right_side;
    each_touching([&](int, int x) { right_side.middleRows(x, 2).setZero(); });
    block_.left_.eliminate(first_, right_side);
    block_.right_.eliminate(last_, right_side);
    each_touching([&](int i, int x) {
      if (slips(trial_[i])) {
        right_side.row(x) += friction_sign(trial_[i]) * mu_ * right_side.row(x + 1) + given.row(x);
      } else {
        right_side.row(x) = stiffness_at(x) * given.row(x);
      }
      right_side.row(x + 1) = stiffness_at(x + 1) * given.row(x + 1);
    });
    matrix_.solve(right_side.middleRows(begin_, block_.order_.first[last_ + 1] - begin_));
    block_.left_.substitute(first_, right_side);
    block_.right_.substitute(last_, right_side);
  }

  /// What is missing in each row, [unknowns, k].
  RowMatrix residual(const Extended& right_side, const Extended& displacement) const {
    const auto& order = block_.order_;
    RowMatrix missing(order.size(), right_side.cols());
    for (Eigen::Index k = 0; k < missing.cols(); ++k) {
      const auto force = [&](int p) { return block_.force(order.dof[p], displacement, k); };
      for (int p = 0; p < order.size(); ++p) {
        if (!prescribed_[p]) missing(p, k) = double(-force(p));
      }
      for (int i = 0; i < int(trial_.size()); ++i) {
        const int x = block_.unknown_of(i);
        const auto u = [&](int p) { return displacement(order.dof[p], k); };
        const long double given_x = right_side(2 * i, k), given_y = right_side(2 * i + 1, k);
        const long double friction = friction_sign(trial_[i]) * mu_;
        missing(x, k) = double(given_x - (trial_[i] == Trial::stick ? u(x) : force(x) + friction * force(x + 1)));
        missing(x + 1, k) = double(given_y - (touches(trial_[i]) ? u(x + 1) : force(x + 1)));
      }
    }
    return missing;
  }

 private:
  int first_touching() const {
    const auto first = std::find_if(trial_.begin(), trial_.end(), touches);
    return first == trial_.end() ? 0 : int(first - trial_.begin());
  }
  int last_touching() const {
    const auto last = std::find_if(trial_.rbegin(), trial_.rend(), touches);
    return last == trial_.rend() ? 0 : int(trial_.rend() - last) - 1;
  }
  double stiffness_at(int p) const { return block_.stiffness_.coeff(block_.order_.dof[p], block_.order_.dof[p]); }

  // action(node, unknown of its x)
  template <class Action>
  void each_touching(Action action) const {
    for (int i = first_; i <= last_; ++i) {
      if (touches(trial_[i])) action(i, block_.unknown_of(i));
    }
  }

  // factor times row `source` of K, into row `target`: the part among the window's columns, but for the outermost
  // columns' own blocks.
  void add_row(int target, int source, double factor) {
    const auto& order = block_.order_;
    const auto inside = [&](int c, int p) { return p >= order.first[c] && p < order.first[c + 1]; };
    const auto reduced = [&](int p) {
      return (inside(first_, source) && inside(first_, p)) || (inside(last_, source) && inside(last_, p));
    };
    for (Eigen::SparseMatrix<double>::InnerIterator entry(block_.stiffness_, order.dof[source]); entry; ++entry) {
      const int p = order.place[entry.row()];
      if (p < begin_ || p >= order.first[last_ + 1]) continue;
      // One column alone stands between both ends: K + (left - K) + (right - K).
      const double share = !reduced(p) ? 1 : first_ == last_ ? -1 : 0;
      matrix_.entry(target - begin_, p - begin_) += factor * share * entry.value();
    }
    for (auto [column, end] : {std::pair(first_, &left_end_), std::pair(last_, &right_end_)}) {
      if (!inside(column, source)) continue;
      const auto row = end->row(source - order.first[column]);
      for (int j = 0; j < row.size(); ++j)
        matrix_.entry(target - begin_, order.first[column] + j - begin_) += factor * row(j);
    }
  }

  void assemble() {
    each_touching([&](int i, int x) {
      prescribed_[x] = prescribed_[x + 1] = 1;
      matrix_.entry(x + 1 - begin_, x + 1 - begin_) = stiffness_at(x + 1);  // scaled like its neighbours
      if (!slips(trial_[i])) {
        matrix_.entry(x - begin_, x - begin_) = stiffness_at(x);
      } else {
        add_row(x, x, 1);
        if (mu_ != 0) add_row(x, x + 1, friction_sign(trial_[i]) * mu_);
      }
    });
    for (int p = begin_; p < block_.order_.first[last_ + 1]; ++p) {
      if (!prescribed_[p]) add_row(p, p, 1);
    }
  }

  GapBlock& block_;
  const std::vector<Trial>& trial_;
  double mu_;
  int first_, last_;                      // outermost columns that touch
  int begin_;                             // first unknown of column first_
  Eigen::MatrixXd left_end_, right_end_;  // diagonal blocks of the outermost columns, with all beyond them eliminated
  BandedLu matrix_;
  std::vector<char> prescribed_;  // [unknowns] rows of touching nodes
  bool regular_ = false;
};

GapBlock::GapBlock(Mesh mesh, const Eigen::SparseMatrix<double>& stiffness)
    : mesh_(std::move(mesh)),
      stiffness_(stiffness),
      exact_stiffness_(without_rigid_forces(stiffness_)),
      order_(order_by_column(mesh_)),
      band_(band_of(stiffness_, order_)),
      left_(ordered(stiffness_, order_), order_, OpenColumns::From::left),
      right_(ordered(stiffness_, order_), order_, OpenColumns::From::right) {}

std::optional<Extended> GapBlock::solve(const std::vector<Trial>& trial, double mu, const Extended& right_side) {
  const System system(*this, trial, mu);
  if (!system.regular()) return std::nullopt;
  Extended displacement = Extended::Zero(stiffness_.rows(), right_side.cols());
  double before = 1;
  for (int pass = 0; pass < most_passes; ++pass) {
    RowMatrix correction = system.residual(right_side, displacement);
    system.solve(correction);
    for (int p = 0; p < order_.size(); ++p) displacement.row(order_.dof[p]) += correction.row(p).cast<long double>();
    const double size = correction.norm() / std::max(1e-300, double(displacement.norm()));
    if (size * size < refined * before) break;  // the next correction shrinks by as much as this one did
    before = size;
  }
  return displacement;
}

long double GapBlock::force(int dof, const Extended& displacement, Eigen::Index side) const {
  long double sum = 0;
  for (decltype(exact_stiffness_)::InnerIterator entry(exact_stiffness_, dof); entry; ++entry) {
    sum += entry.value() * displacement(entry.col(), side);
  }
  return sum;
}

Extended GapBlock::forces(const std::vector<int>& nodes, const Extended& displacement) const {
  Extended result(2 * nodes.size(), displacement.cols());
  for (Eigen::Index k = 0; k < result.cols(); ++k) {
    for (Eigen::Index j = 0; j < result.rows(); ++j)
      result(j, k) = force(2 * nodes[j / 2] + int(j % 2), displacement, k);
  }
  return result;
}

Extended GapBlock::surface_force(const Extended& displacement) const { return forces(mesh_.surface, displacement); }

Extended GapBlock::base_force(const Extended& displacement) const { return -forces(mesh_.base, displacement); }

Extended GapBlock::surface_displacement(const Extended& displacement) const {
  Extended result(2 * columns(), displacement.cols());
  for (int i = 0; i < columns(); ++i) result.middleRows(2 * i, 2) = displacement.middleRows(2 * mesh_.surface[i], 2);
  return result;
}

double GapBlock::typical_stiffness() const {
  double sum = 0;
  for (int node : mesh_.surface)
    sum += stiffness_.coeff(2 * node, 2 * node) + stiffness_.coeff(2 * node + 1, 2 * node + 1);
  return sum / (2 * columns());
}

}  // namespace tactel::fem
