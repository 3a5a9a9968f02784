// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/brick_block.h"

#include <Eigen/Sparse>
#include <array>
#include <vector>

#include "fem/pad/parity.h"

namespace tactel::fem {
namespace {

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Triplets = std::vector<Eigen::Triplet<double>>;
using Blocks = std::array<std::array<Sparse, 2>, 2>;  ///< [plane][plane] of a slab

/// A quarter of the block under one parity.
class Quarter {
 public:
  Quarter(const BrickMesh& mesh, double poisson, Parity parity)
      : mesh_(mesh),
        parity_(parity),
        planes_(mesh.nx / 2 * mesh.along + 1),
        across_(mesh.ny / 2 * mesh.along + 1),
        cells_{mesh.nx / 2, mesh.ny / 2} {
    number();
    assemble(poisson);
  }

  /// [3 cells][3 sources]: mean displacements of the quarter's cells.
  Eigen::MatrixXd solve(const std::function<void()>& between) const;

 private:
  void number();
  void assemble(double poisson);
  void hold_middle(Eigen::MatrixXd& stiffness) const;
  Eigen::MatrixXd loads(int plane) const;
  double weight(int node, int cell) const;
  int first_sources(int plane) const;
  int at(int j, int k, int component) const { return 3 * (j * mesh_.layers() + k - 1) + component; }

  const BrickMesh& mesh_;
  Parity parity_;
  int planes_, across_;
  std::array<int, 2> cells_;   ///< along x and y
  std::vector<int> unknowns_;  ///< [across, layers, 3]: number within a plane; -1: held by parity in y
  std::vector<int> middle_;    ///< unknowns of the plane x = 0 that parity holds
  int size_ = 0;               ///< unknowns of a plane
  Blocks slab_;                ///< between unknowns
};

void Quarter::number() {
  for (int j = 0; j < across_; ++j)
    for (int k = 1; k <= mesh_.layers(); ++k)
      for (int c = 0; c < 3; ++c) {
        const bool held = j == 0 && parity_.in_y(c) < 0;
        unknowns_.push_back(held ? -1 : size_);
        if (held) continue;
        if (parity_.in_x(c) < 0) middle_.push_back(size_);
        ++size_;
      }
}

void Quarter::assemble(double poisson) {
  std::array<std::array<Triplets, 2>, 2> slab;
  for (int k = 0; k < mesh_.layers(); ++k) {
    const BrickMatrix brick = brick_stiffness(mesh_.dx(), mesh_.dy(), mesh_.levels[k + 1] - mesh_.levels[k], poisson);
    for (int j = 0; j + 1 < across_; ++j)
      for (int row = 0; row < 24; ++row)
        for (int column = 0; column < 24; ++column) {
          const auto [rx, ry, rz, rc] = std::array{row / 12, row / 6 % 2, row / 3 % 2, row % 3};
          const auto [cx, cy, cz, cc] = std::array{column / 12, column / 6 % 2, column / 3 % 2, column % 3};
          if (k + cz == 0 || k + rz == 0) continue;
          const int to = unknowns_[at(j + cy, k + cz, cc)];
          const int from = unknowns_[at(j + ry, k + rz, rc)];
          if (from >= 0 && to >= 0) slab[rx][cx].emplace_back(from, to, brick(row, column));
        }
  }
  for (const int a : {0, 1})
    for (const int b : {0, 1}) {
      slab_[a][b].resize(size_, size_);
      slab_[a][b].setFromTriplets(slab[a][b].begin(), slab[a][b].end());
    }
}

/// Holds in the plane x = 0 what is odd there.
void Quarter::hold_middle(Eigen::MatrixXd& stiffness) const {
  for (const int i : middle_) {
    stiffness.row(i).setZero(), stiffness.col(i).setZero();
    stiffness(i, i) = 1;
  }
}

/// Integral of a node's hat function over a cell, over the side of a brick.
double Quarter::weight(int node, int cell) const {
  const int from = node - cell * mesh_.along;
  return from < 0 || from > mesh_.along ? 0 : from == 0 || from == mesh_.along ? 0.5 : 1;
}

/// Number of sources that planes up to this one bear.
int Quarter::first_sources(int plane) const { return 3 * cells_[1] * std::min(cells_[0], plane / mesh_.along + 1); }

/// Forces on the surface in a plane, [unknowns][sources up to this plane].
Eigen::MatrixXd Quarter::loads(int plane) const {
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(size_, first_sources(plane));
  for (int source = 0; source < f.cols(); ++source) {
    const auto [i, j, c] = std::array{source / 3 / cells_[1], source / 3 % cells_[1], source % 3};
    const double along_x = mesh_.dx() * mesh_.dy() * weight(plane, i);
    if (along_x == 0) continue;
    for (int node = j * mesh_.along; node <= (j + 1) * mesh_.along; ++node)
      if (const int to = unknowns_[at(node, mesh_.layers(), c)]; to >= 0) f(to, source) = along_x * weight(node, j);
  }
  if (plane == 0)
    for (const int i : middle_) f.row(i).setZero();
  return f;
}

Eigen::MatrixXd Quarter::solve(const std::function<void()>& between) const {
  const int last = planes_ - 1, sources = 3 * cells_[0] * cells_[1];
  // Forward: S_k = K_kk - L S_(k-1)^-1 L', the inverses and S_k^-1 f_k are kept. Parity holds rows and columns of the
  // first plane, whose inverse therefore has none of them but ones on the diagonal, which L must not see.
  std::vector<Eigen::MatrixXd> inverse(planes_), solved(planes_);
  const Sparse &down = slab_[1][0], &up = slab_[0][1];
  for (int k = 0; k < planes_; ++k) {
    between();
    Eigen::MatrixXd s = Eigen::MatrixXd::Zero(size_, size_), f = loads(k);
    if (k < last) s += slab_[0][0];
    if (k > 0) {
      s += slab_[1][1];
      const Eigen::MatrixXd left = down * inverse[k - 1];
      s -= left * up;
      f.leftCols(solved[k - 1].cols()) -= down * solved[k - 1];
    } else {
      hold_middle(s);
    }
    const Eigen::LLT<Eigen::MatrixXd> factor(s);
    inverse[k] = factor.solve(Eigen::MatrixXd::Identity(size_, size_));
    if (k == 0)
      for (const int i : middle_) inverse[k](i, i) = 0;
    solved[k] = inverse[k] * f;
  }
  // Back, with means over cells.
  Eigen::MatrixXd surface = Eigen::MatrixXd::Zero(sources, sources), u;
  for (int k = last; k >= 0; --k) {
    between();
    Eigen::MatrixXd now =
        k == last ? Eigen::MatrixXd(Eigen::MatrixXd::Zero(size_, sources)) : Eigen::MatrixXd(-(inverse[k] * (up * u)));
    now.leftCols(solved[k].cols()) += solved[k];
    u = std::move(now);
    for (int i = 0; i < cells_[0]; ++i) {
      const double along_x = weight(k, i) / (mesh_.along * mesh_.along);
      if (along_x == 0) continue;
      for (int j = 0; j < cells_[1]; ++j)
        for (int node = j * mesh_.along; node <= (j + 1) * mesh_.along; ++node)
          for (int c = 0; c < 3; ++c)
            if (const int from = unknowns_[at(node, mesh_.layers(), c)]; from >= 0)
              surface.row(3 * (i * cells_[1] + j) + c) += along_x * weight(node, j) * u.row(from);
    }
  }
  return surface;
}

/// Swaps x and y: rows and columns of [3 (i n + j) + component], i and j up to n.
Eigen::MatrixXd transposed(const Eigen::MatrixXd& m, int n) {
  Eigen::VectorXi to(3 * n * n);
  constexpr std::array other{1, 0, 2};
  for (int k = 0; k < to.size(); ++k) to[k] = 3 * (k / 3 % n * n + k / 3 / n) + other[k % 3];
  return m(to, to);
}

}  // namespace

Eigen::MatrixXd brick_block(const BrickMesh& mesh, double poisson, const std::function<void()>& between) {
  const std::array<int, 2> cells{mesh.nx / 2, mesh.ny / 2};
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3) * mesh.nx * mesh.ny,
                                                static_cast<Eigen::Index>(3) * cells[0] * cells[1]);
  const bool square = mesh.nx == mesh.ny && mesh.hx == mesh.hy;
  Eigen::MatrixXd now;
  for (const Parity parity : {Parity{1, 1}, Parity{1, -1}, Parity{-1, 1}, Parity{-1, -1}}) {
    if (square && parity.x < parity.y)  // the one before, mirrored
      now = transposed(now, cells[0]);
    else
      now = Quarter(mesh, poisson, parity).solve(between);
    unfold(now, parity, cells, whole);
  }
  return whole;
}

}  // namespace tactel::fem
