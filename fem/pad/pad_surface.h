// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>

#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// Part of a cell by which an object with sharp edges is larger to cells fixed to the pad. Pressure is singular at such
/// an edge: as straight_overhang of fitted cells, or of means where sides are free.
inline constexpr double cover_overhang = straight_overhang, cover_overhang_of_means = straight_overhang_of_means;

/// Returns the grid of equal cells about the pad's middle: along x and y, sides in mm.
PadCells fixed_cells(std::array<int, 2> along, std::array<double, 2> sides);
/// n x n square ones.
inline PadCells fixed_cells(int n, double side) { return fixed_cells({n, n}, {side, side}); }

/// An object over cells fixed to the pad. A cell below a sharp edge is covered by the share f of its area; its rubber
/// gives way where it is not covered, so that it has the compliance 1 / f - 1 of its own, over that on itself.
struct PadSurface {
  Eigen::ArrayXd height;  ///< [cells] mm above the object's lowest point; +infinity where no part is covered
  Eigen::ArrayXd cover;   ///< [cells] 0 to 1
};

/// Returns the surface of an indenter whose axis lies at `place`, x, y (mm) on the pad, turned by `yaw` degrees beside
/// its own. With `free_sides` the influence of cells is a mean, and covers are twice as fine.
PadSurface pad_surface(const PadCells& cells, const PadIndenter& indenter, std::array<double, 2> place, double yaw,
                       bool free_sides = false);

/// Adds what a curved skin falls (fall_of_skin) to the heights of an object, [cells] mm, which are then above the skin.
void add_skin(const PadSensor& sensor, const PadCells& cells, Eigen::Ref<Eigen::ArrayXd> heights);

/// Returns the least height, mm, of an indenter as above over rubber beyond the grid, of places in a ring of cells
/// around it and the one that is nearest to the axis; +infinity: no object or no rubber is there.
double height_beyond(const PadCells& cells, const PadIndenter& indenter, std::array<double, 2> place, double yaw,
                     const PadBox& rubber);

}  // namespace tactel::fem
