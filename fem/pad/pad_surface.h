// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>

#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// Part of a cell by which an object with sharp edges is larger to cells fixed to the pad. Pressure is singular at such
/// an edge: as straight_overhang of fitted cells.
inline constexpr double cover_overhang = 0.15;

/// Returns the grid of n x n square cells about the pad's middle.
PadCells fixed_cells(int n, double side);

/// An object over cells fixed to the pad. A cell below a sharp edge is covered by the share f of its area; its rubber
/// gives way where it is not covered, so that it has the compliance 1 / f - 1 of its own, over that on itself.
struct PadSurface {
  Eigen::ArrayXd height;  ///< [cells] mm above the object's lowest point; +infinity where no part is covered
  Eigen::ArrayXd cover;   ///< [cells] 0 to 1
};

/// Returns the surface of an indenter whose axis lies at `place`, x, y (mm) on the pad, turned by `yaw` degrees beside
/// its own.
PadSurface pad_surface(const PadCells& cells, const PadIndenter& indenter, std::array<double, 2> place, double yaw);

}  // namespace tactel::fem
