// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_table.h"

#include <cmath>

#include "fem/pad/layer_means.h"

namespace tactel::fem {

PadTable::PadTable(const PadLayer& layer, double thickness, const PadCells& cells)
    : nx_(cells.n), ny_(cells.ny()), count_(cells.count()) {
  numbers_.resize(begin(nx_, ny_) + 9 * count_);
  const int n = std::max(nx_, ny_);
  const std::vector<CellInfluence> means = layer_means(layer, thickness, cells.hx, cells.hy, n);
  for (int ix = -1; ix <= nx_; ++ix)
    for (int iy = -1; iy <= ny_; ++iy)
      for (int source = 0; source < count_; ++source) {
        const int dx = ix - source / ny_, dy = iy - source % ny_, sx = dx < 0 ? -1 : 1, sy = dy < 0 ? -1 : 1;
        const CellInfluence& c = means[std::abs(dx) * (n + 1) + std::abs(dy)];
        at(ix, iy, 0, 0, source) = c.xx, at(ix, iy, 1, 1, source) = c.yy, at(ix, iy, 2, 2, source) = c.zz;
        at(ix, iy, 0, 1, source) = at(ix, iy, 1, 0, source) = sx * sy * c.xy;
        at(ix, iy, 0, 2, source) = sx * c.xz, at(ix, iy, 2, 0, source) = -sx * c.xz;
        at(ix, iy, 1, 2, source) = sy * c.yz, at(ix, iy, 2, 1, source) = -sy * c.yz;
      }
}

PadTable::PadTable(const PadLayer& layer, const PadSides& sides, const PadCells& cells, const Eigen::Matrix2d& turn,
                   const Eigen::Vector2d& origin)
    : PadTable(layer, sides.thickness, cells) {
  const SideKernel& kernel = *sides.kernel;
  const auto shares_at = [&](int ix, int iy) {
    const Eigen::Vector2d place = sides.in_block(origin + turn * Eigen::Vector2d(cells.x(ix), cells.y(iy)));
    return kernel.shares(place[0], place[1]);
  };
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned.topLeftCorner<2, 2>() = turn;
  const double scale = cells.area() / sides.thickness;  // unit traction is this force, over H^2, and lengths are over H
  // What each cell does to the nodes: [3 nodes][3 cells], then what places make of that.
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows to_nodes = Rows::Zero(kernel.displacement().rows(), 3 * count_);
  for (int source = 0; source < count_; ++source) {
    const SideKernel::Shares by = shares_at(source / ny_, source % ny_);
    for (int k = 0; k < by.count; ++k)
      to_nodes.middleCols<3>(3 * source) +=
          scale * by.share[k] * kernel.displacement().middleCols<3>(3 * by.node[k]) * turned;
  }
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> at_place(3, 3 * count_);
  for (int ix = -1; ix <= nx_; ++ix)
    for (int iy = -1; iy <= ny_; ++iy) {
      const SideKernel::Shares of = shares_at(ix, iy);
      if (of.count == 0) continue;
      at_place.setZero();
      for (int k = 0; k < of.count; ++k) at_place += of.share[k] * to_nodes.middleRows<3>(3 * of.node[k]);
      at_place = (turned.transpose() * at_place).eval();
      for (int to = 0; to < 3; ++to)
        for (int source = 0; source < count_; ++source)
          for (int by = 0; by < 3; ++by) at(ix, iy, to, by, source) += at_place(to, 3 * source + by);
    }
}

void PadTable::soften(int i, double compliance) {
  for (int c = 0; c < 3; ++c) at(i / ny_, i % ny_, c, c, i) += compliance;
}

Eigen::MatrixXd PadTable::matrix() const {
  Eigen::MatrixXd m(3 * count_, 3 * count_);
  for (int i = 0; i < count_; ++i)
    for (int to = 0; to < 3; ++to)
      for (int by = 0; by < 3; ++by)
        for (int source = 0; source < count_; ++source)
          m(3 * i + to, 3 * source + by) = row(i / ny_, i % ny_, to, by)[source];
  return m;
}

}  // namespace tactel::fem
