// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

namespace tactel::fem {

/// Cells of the surface of a block with free sides, between whose middles what sides do is interpolated. Lengths over
/// H.
struct SideGrid {
  std::array<double, 2> sides;  ///< of the block
  std::array<int, 2> cells;     ///< along x and y, even

  double cell(int axis) const { return sides[axis] / cells[axis]; }

  /// Nodes of the grid with their weights, at a place: x, y from the block's middle; cubic in each direction. None
  /// beyond the block.
  struct Shares {
    std::array<int, 16> node;  ///< [i cells[1] + j]
    std::array<double, 16> share;
    int count = 0;
  };
  Shares shares(double x, double y) const;
};

}  // namespace tactel::fem
