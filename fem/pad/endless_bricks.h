// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <vector>

#include "fem/pad/brick.h"

namespace tactel::fem {

/// What a unit traction on a cell of an endless layer of bricks does, E = 1, by the offset from the cell's middle.
struct EndlessResponse {
  /// Mean displacement of cells that lie i and j cells off, 0 <= i < nx, 0 <= j < ny: zz, xx, yy, xy, xz, yz as in
  /// PadInfluence, [nx][ny] each.
  std::array<Eigen::MatrixXd, 6> surface;
  /// Force of the rubber on nodes of the base, (force, traction) along x, y and z: xx, xy, xz, yx, ... zz; [a][b] for
  /// nodes that lie (a + along / 2 mod 1) bricks off along x, and b alike.
  std::array<Eigen::MatrixXd, 9> base;
};

/// Solves the layer, of the mesh's bricks, by Fourier series over a period of so many bricks: three unknowns a level
/// for each pair of wave numbers. The real form takes -i u_z for u_z (by reflection).
EndlessResponse endless_bricks(const BrickMesh& mesh, double poisson, int period);

}  // namespace tactel::fem
