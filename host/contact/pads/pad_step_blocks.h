// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace tactel::host {

/// What kernels/pad/splitting.h takes of a grid of nx x ny cells.
struct SplitBlocks {
  /// Of fields even and odd along x and y, on a quarter of the grid: [2][4][rounds][rows][STEP_ROUND], B and
  /// (B + rho)^-1. Empty where the grid is not its own image along x and along y.
  std::vector<double> numbers;
  double rho_n = 1, rho_t = 1;  ///< over what a cell does to itself
};
/// `table`: the kernel's own, of pairs or of offsets.
SplitBlocks split_blocks(const std::vector<double>& table, bool pairs, int nx, int ny);

}  // namespace tactel::host
