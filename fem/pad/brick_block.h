// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <functional>

#include "fem/pad/brick.h"

namespace tactel::fem {

/// Condenses a block of bricks with free sides and a rigid base to its surface: the mean displacement of each cell,
/// [3 (i ny + j) + component], by unit tractions on cells of one quarter, E = 1: [3 nx ny][3 sources]. Sources: cells
/// (i, j) of the quarter x > 0, y > 0, i along x from the middle, [i ny / 2 + j], x, y, z of each. A quarter is solved
/// for each of the four parities about the planes x = 0 and y = 0, three of them on a square; its planes x = const are
/// eliminated one after another (block tridiagonal, dense Cholesky factors). `between` is called before each plane and
/// may throw, which ends it.
Eigen::MatrixXd brick_block(
    const BrickMesh& mesh, double poisson, const std::function<void()>& between = [] {});

}  // namespace tactel::fem
