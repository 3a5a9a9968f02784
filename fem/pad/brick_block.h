// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

#include "fem/pad/brick.h"

namespace tactel::fem {

/// What unit tractions on cells of one quarter of a block's surface do to it, E = 1. The block has free sides and a
/// rigid base. Sources: cells (i, j) of the quarter x > 0, y > 0, i along x from the middle, [i ny / 2 + j], x, y, z of
/// each.
struct BrickResponse {
  Eigen::MatrixXd surface;  ///< [3 nx ny][3 sources]: mean displacement of each cell, [3 (i ny + j) + component]
  Eigen::MatrixXd base;     ///< [3 (nx along + 1) (ny along + 1)][3 sources]: force of the rubber on each node of the
                            ///< base, index alike; sums to the applied force
};

/// Condenses a block of bricks to its surface. A quarter is solved for each of the four parities about the planes x = 0
/// and y = 0, three of them on a square; its planes x = const are eliminated one after another (block tridiagonal,
/// dense Cholesky factors).
BrickResponse brick_block(const BrickMesh& mesh, double poisson);

}  // namespace tactel::fem
