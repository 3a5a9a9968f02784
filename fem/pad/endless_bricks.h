// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <functional>
#include <vector>

#include "fem/pad/brick.h"

namespace tactel::fem {

/// Mean displacement of cells by a unit traction on a cell of an endless layer of bricks, E = 1, i and j cells off,
/// 0 <= i < nx, 0 <= j < ny: zz, xx, yy, xy, xz, yz as in PadInfluence, [nx][ny] each.
using EndlessResponse = std::array<Eigen::MatrixXd, 6>;

/// Solves the layer, of the mesh's bricks, by Fourier series over periods of so many bricks along x and y: three
/// unknowns a level for each pair of wave numbers. The real form takes -i u_z for u_z (by reflection). `between` is
/// called before each wave number along x and may throw, which ends it.
EndlessResponse endless_bricks(
    const BrickMesh& mesh, double poisson, const std::array<int, 2>& period,
    const std::function<void()>& between = [] {});

}  // namespace tactel::fem
