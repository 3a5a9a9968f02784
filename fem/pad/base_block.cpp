// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/base_block.h"

#include <algorithm>
#include <map>
#include <numbers>

#include "fem/layer/legendre_points.h"
#include "fem/pad/mixed_brick.h"
#include "fem/pad/parity.h"

namespace tactel::fem {
namespace {

constexpr double gauss = 1 / std::numbers::sqrt3;  ///< where stress is right to one order more

int bricks(const std::vector<double>& edges) { return static_cast<int>(edges.size()) - 1; }

/// The integrals of the nodes' functions over each cell, [nodes][cells], along one axis.
Eigen::MatrixXd loads(const std::vector<double>& edges, int cells) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(2 * bricks(edges) + 1, cells);
  const double cell = edges.back() / cells;
  for (int e = 0; e < bricks(edges); ++e)
    for (int i = 0; i < cells; ++i) {
      const double side = edges[e + 1] - edges[e], from = std::max(edges[e], i * cell),
                   to = std::min(edges[e + 1], (i + 1) * cell);
      if (to <= from) continue;
      for (const LegendrePoint& p : legendre_points(2)) {
        const double at = (from + to + p.x * (to - from)) / 2;
        all.block<3, 1>(2 * e, i) += (p.weight * (to - from) / 2 * quadratics(2 * (at - edges[e]) / side - 1)).matrix();
      }
    }
  return all;
}

/// The bricks of a mesh, by their sides.
class Bricks {
 public:
  explicit Bricks(double poisson) : poisson_(poisson) {}

  const MixedBrick& at(const BaseMesh& mesh, int i, int j, int k) {
    const double hx = mesh.x[i + 1] - mesh.x[i], hy = mesh.y[j + 1] - mesh.y[j], hz = mesh.z[k + 1] - mesh.z[k];
    return all_.try_emplace({hx, hy, hz}, hx, hy, hz, poisson_).first->second;
  }

 private:
  double poisson_;
  std::map<std::array<double, 3>, MixedBrick> all_;
};

/// A quarter of the block under a parity in y. Planes x = const through nodes: 2 e, 2 e + 1 and 2 e + 2 bound and halve
/// column e of bricks.
class BaseQuarter {
 public:
  BaseQuarter(const BaseMesh& mesh, const std::array<int, 2>& cells, Bricks& all, int parity_y,
              const std::function<void()>& between)
      : mesh_(mesh),
        cells_(cells),
        parity_y_(parity_y),
        columns_(bricks(mesh.x)),
        across_(2 * bricks(mesh.y) + 1),
        levels_(2 * bricks(mesh.z)),
        size_(3 * across_ * levels_),
        bricks_(all) {
    eliminate(between);
  }

  /// [3 places of the quarter][3 sources].
  Eigen::MatrixXd stress(int parity_x, const std::function<void()>& between) const;

 private:
  struct Column {
    Eigen::LLT<Eigen::MatrixXd> factor;  ///< of its planes but the first
    Eigen::MatrixXd to_first;            ///< L^-1 K, [2 size][size]
    Eigen::MatrixXd load;                ///< L^-1 f, [2 size][3 sources]
  };
  Eigen::MatrixXd stiffness(int column) const;
  Eigen::MatrixXd load(int plane) const;
  void eliminate(const std::function<void()>& between);
  int at(int j, int k, int c) const { return 3 * (j * levels_ + k - 1) + c; }  ///< k: 1 to levels_
  bool held(int j, int c) const { return j == 0 && Parity{1, parity_y_}.in_y(c) < 0; }

  const BaseMesh& mesh_;
  std::array<int, 2> cells_;
  int parity_y_, columns_, across_, levels_, size_;
  Bricks& bricks_;
  std::vector<Column> eliminated_;  ///< [columns]
  Eigen::MatrixXd middle_, middle_load_;
};

/// Of a column's three planes, [3 size][3 size]; what parity in y holds has ones on the diagonal.
Eigen::MatrixXd BaseQuarter::stiffness(int column) const {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3 * size_, 3 * size_);
  std::array<int, MixedBrick::unknowns> place;
  for (int j = 0; j < bricks(mesh_.y); ++j)
    for (int k = 0; k < bricks(mesh_.z); ++k) {
      for (int n = 0; n < MixedBrick::unknowns; ++n) {
        const int plane = n / 27, across = 2 * j + n / 9 % 3, level = 2 * k + n / 3 % 3, c = n % 3;
        place[n] = level == 0 || held(across, c) ? -1 : plane * size_ + at(across, level, c);
      }
      const Eigen::MatrixXd& own = bricks_.at(mesh_, column, j, k).stiffness();
      for (int n = 0; n < MixedBrick::unknowns; ++n)
        for (int m = 0; m < MixedBrick::unknowns; ++m)
          if (place[n] >= 0 && place[m] >= 0) all(place[m], place[n]) += own(m, n);
    }
  for (int i = 0; i < 3 * size_; ++i)
    if (all(i, i) == 0) all(i, i) = 1;
  return all;
}

/// Forces of the sources on a plane, [size][3 sources].
Eigen::MatrixXd BaseQuarter::load(int plane) const {
  const Eigen::MatrixXd along = loads(mesh_.x, cells_[0]), across = loads(mesh_.y, cells_[1]);
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(size_, 3 * cells_[0] * cells_[1]);
  for (int source = 0; source < cells_[0] * cells_[1]; ++source)
    for (int j = 0; j < across_; ++j)
      for (int c = 0; c < 3; ++c)
        if (!held(j, c))
          f(at(j, levels_, c), 3 * source + c) = along(plane, source / cells_[1]) * across(j, source % cells_[1]);
  return f;
}

void BaseQuarter::eliminate(const std::function<void()>& between) {
  eliminated_.resize(columns_);
  middle_ = Eigen::MatrixXd::Zero(size_, size_);
  middle_load_ = load(2 * columns_);
  for (int e = columns_ - 1; e >= 0; --e) {
    between();
    Column& column = eliminated_[e];
    Eigen::MatrixXd k = stiffness(e);
    k.bottomRightCorner(size_, size_) += middle_;
    column.factor.compute(k.bottomRightCorner(2 * size_, 2 * size_));
    const auto lower = column.factor.matrixL();
    column.to_first = lower.solve(k.bottomLeftCorner(2 * size_, size_));
    Eigen::MatrixXd f(2 * size_, middle_load_.cols());
    f << load(2 * e + 1), middle_load_;
    column.load = lower.solve(f);
    middle_ = k.topLeftCorner(size_, size_);
    middle_.selfadjointView<Eigen::Lower>().rankUpdate(column.to_first.transpose(), -1);
    middle_.triangularView<Eigen::StrictlyUpper>() = middle_.transpose();
    middle_load_ = load(2 * e) - column.to_first.transpose() * column.load;
  }
}

Eigen::MatrixXd BaseQuarter::stress(int parity_x, const std::function<void()>& between) const {
  Eigen::MatrixXd k = middle_, u = middle_load_;
  for (int i = 0; i < size_; ++i)
    if (Parity{parity_x, 1}.in_x(i % 3) < 0) k.row(i).setZero(), k.col(i).setZero(), u.row(i).setZero(), k(i, i) = 1;
  u = k.llt().solve(u);
  const int places_y = 2 * bricks(mesh_.y);
  Eigen::MatrixXd stress(static_cast<Eigen::Index>(3) * 2 * columns_ * places_y, u.cols());
  for (int e = 0; e < columns_; ++e) {
    between();
    const Column& column = eliminated_[e];
    Eigen::MatrixXd planes(3 * size_, u.cols());
    planes << u, column.factor.matrixU().solve(column.load - column.to_first * u);
    for (int j = 0; j < bricks(mesh_.y); ++j) {
      Eigen::MatrixXd own = Eigen::MatrixXd::Zero(MixedBrick::unknowns, u.cols());
      for (int n = 0; n < MixedBrick::unknowns; ++n)
        if (const int level = n / 3 % 3; level > 0)
          own.row(n) = planes.row(n / 27 * size_ + at(2 * j + n / 9 % 3, level, n % 3));
      const MixedBrick& brick = bricks_.at(mesh_, e, j, 0);
      for (const int a : {0, 1})
        for (const int b : {0, 1})
          stress.middleRows(3 * ((2 * e + a) * places_y + 2 * j + b), 3) =
              brick.face_stress(a ? gauss : -gauss, b ? gauss : -gauss) * own;
    }
    u = planes.bottomRows(size_);
  }
  return stress;
}

}  // namespace

std::vector<double> gauss_places(const std::vector<double>& edges) {
  std::vector<double> all;
  for (int e = 0; e < bricks(edges); ++e)
    for (const double sign : {-1, 1}) {
      const double at = (edges[e] + edges[e + 1]) / 2 + sign * gauss * (edges[e + 1] - edges[e]) / 2;
      all.push_back(at), all.push_back(-at);
    }
  std::ranges::sort(all);
  return all;
}

std::vector<double> graded_edges(double length, double finest, double growth,
                                 const std::function<double(double)>& widest) {
  std::vector<double> from_side{0};
  for (double h = finest; from_side.back() < length * (1 - 1e-9); h = std::min(growth * h, widest(from_side.back())))
    from_side.push_back(from_side.back() + h);
  std::vector<double> edges;
  edges.reserve(from_side.size());
  for (const double at : from_side) edges.push_back(length * (1 - at / from_side.back()));
  std::ranges::reverse(edges);
  return edges;
}

Eigen::MatrixXd base_block(const BaseMesh& mesh, const std::array<int, 2>& cells, double poisson,
                           const std::function<void()>& between) {
  const std::array<int, 2> places{2 * bricks(mesh.x), 2 * bricks(mesh.y)};
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3) * 4 * places[0] * places[1],
                                                static_cast<Eigen::Index>(3) * cells[0] * cells[1]);
  Bricks bricks(poisson);
  for (const int parity_y : {1, -1}) {
    const BaseQuarter quarter(mesh, cells, bricks, parity_y, between);
    for (const int parity_x : {1, -1}) unfold(quarter.stress(parity_x, between), {parity_x, parity_y}, places, whole);
  }
  return whole;
}

}  // namespace tactel::fem
