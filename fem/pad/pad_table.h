// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "fem/pad/pad_cells.h"
#include "fem/pad/side_kernel.h"

namespace tactel::fem {

/// The influence of cells on each other and on the ring of places around them, E = 1, where it depends on more than
/// their offset: on a pad with free sides. In the frame of the cells, mm by unit tractions.
class PadTable {
 public:
  /// Of the endless layer alone, by means over cells.
  PadTable(const PadLayer& layer, double thickness, const PadCells& cells);
  /// With free sides: `turn` is the frame of the cells on the pad, with its origin at `origin`, mm.
  PadTable(const PadLayer& layer, const PadSides& sides, const PadCells& cells, const Eigen::Matrix2d& turn,
           const Eigen::Vector2d& origin);

  /// [cells]: displacement `to` (0, 1, 2: x, y, z) of place (ix, iy), from -1 to the numbers of cells, by traction `by`
  /// on each cell.
  const double* row(int ix, int iy, int to, int by) const { return &numbers_[begin(ix, iy) + (3 * to + by) * count_]; }

  double own_normal(int i) const { return row(i / ny_, i % ny_, 2, 2)[i]; }
  /// The larger of xx and yy.
  double own_tangential(int i) const {
    return std::max(row(i / ny_, i % ny_, 0, 0)[i], row(i / ny_, i % ny_, 1, 1)[i]);
  }

  /// Gives a cell a compliance of its own, mm, beside that of the rubber.
  void soften(int i, double compliance);

  /// [3 cells][3 cells], x, y, z of each cell.
  Eigen::MatrixXd matrix() const;

 private:
  std::size_t begin(int ix, int iy) const {
    return static_cast<std::size_t>((ix + 1) * (ny_ + 2) + iy + 1) * 9 * count_;
  }
  double& at(int ix, int iy, int to, int by, int source) {
    return numbers_[begin(ix, iy) + (3 * to + by) * count_ + source];
  }

  int nx_, ny_, count_;
  std::vector<double> numbers_;  ///< [nx + 2][ny + 2][3 to][3 by][cells]
};

}  // namespace tactel::fem
