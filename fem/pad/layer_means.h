// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "fem/pad/pad_layer.h"

namespace tactel::fem {

// The layer's part of compliances with free sides. Those are means over cells, since bricks give means: a flat face
// bears some 2 % less by values at the middles of 8 x 8 cells. Tractions are uniform on cells of any size.

/// Returns the mean displacement of cells that lie 0 to n cells off by a unit traction on a cell, [n + 1][n + 1] along
/// x and y, E = 1, mm: PadLayer::influence by 8 x 8 Gauss points over the cell that moves. The own one is 1e-3 off,
/// since the integrand has kinks at its sides.
std::vector<CellInfluence> layer_means(const PadLayer& layer, double thickness, double hx, double hy, int n);

/// Returns the base stress by a uniform unit traction on a cell at an offset, as PadLayer::base_stress.
PadBaseStress uniform_base_stress(const PadLayer& layer, double thickness, double hx, double hy, double x, double y);

}  // namespace tactel::fem
