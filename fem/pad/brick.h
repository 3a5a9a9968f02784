// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace tactel::fem {

/// Order of the unknowns of a brick: corners (i, j, k) along x, y, z with k fastest, x, y, z of each.
using BrickMatrix = Eigen::Matrix<double, 24, 24>;

/// Returns the stiffness of an 8-node brick hx x hy x hz for E = 1, N/mm over MPa: shear part by 2 x 2 x 2 Gauss
/// points, bulk part by the mean dilatation, so that it does not lock near nu = 1/2 (J. C. Nagtegaal, D. M. Parks and
/// J. R. Rice, Comput. Methods Appl. Mech. Eng. 4, 1974, 153-177). 0 <= poisson < 1/2.
BrickMatrix brick_stiffness(double hx, double hy, double hz, double poisson);

inline constexpr double most_poisson_of_bricks = 0.49999;  ///< those of nu = 1/2 are 0.1 % stiffer

/// Bricks under square or rectangular cells of a surface, and in layers below it. Lengths in one unit.
struct BrickMesh {
  int nx = 12, ny = 12;        ///< cells along x and y, even
  double hx = 1, hy = 1;       ///< sides of a cell
  int along = 2;               ///< bricks along a side of a cell
  std::vector<double> levels;  ///< from the base, 0, to the surface

  int layers() const { return static_cast<int>(levels.size()) - 1; }
  double dx() const { return hx / along; }
  double dy() const { return hy / along; }
};

/// Returns the levels of so many layers, each `growth` times as high as the one above it.
std::vector<double> brick_levels(double thickness, int layers, double growth);

}  // namespace tactel::fem
