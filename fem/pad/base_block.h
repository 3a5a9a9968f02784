// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <functional>
#include <vector>

namespace tactel::fem {

/// Bricks of 27 nodes of one quarter of a block, graded to its sides and its base. Lengths over H.
struct BaseMesh {
  std::vector<double> x, y;  ///< edges from the middle, 0, to the side
  std::vector<double> z;     ///< from the base, 0, to the surface, 1
};

/// Returns edges from 0 to `length`, the last brick of about `finest`, each `growth` times as wide as the next one
/// outside of it, up to widest(distance from the side).
std::vector<double> graded_edges(double length, double finest, double growth,
                                 const std::function<double(double)>& widest);

/// Returns the Gauss points of bricks on both sides of the middle, where stress is right to one order more.
std::vector<double> gauss_places(const std::vector<double>& edges);

/// Condenses a block with free sides to the stress on its base by unit tractions on cells of one quarter of the
/// surface, E = 1: tau_x, tau_y, sigma_z at (i, j) of gauss_places, [3 (i count_y + j) + component], [3 places][3
/// sources]. `cells`: number along x and y of the quarter's equal ones; sources (i, j) from the middle outwards, [i
/// cells[1] + j], x, y, z of each. Columns of bricks are eliminated from the side inwards, which both parities about x
/// = 0 share (block tridiagonal, dense Cholesky factors). `between` is called before each column and may throw, which
/// ends it.
Eigen::MatrixXd base_block(
    const BaseMesh& mesh, const std::array<int, 2>& cells, double poisson,
    const std::function<void()>& between = [] {});

}  // namespace tactel::fem
