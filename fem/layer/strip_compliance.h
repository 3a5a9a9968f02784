// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/layer/layer_table.h"

namespace tactel::fem {

/// Displacement of the surface `distance` mm to the right of the middle of a strip of `width` mm that bears a unit
/// force, spread evenly; E = 1 MPa, mm/(N/mm): u_y by f_y, u_x by f_x, u_x by f_y. The means of the kernels of
/// layer_kernels.h over the strip. ElementCompliance is this for equal strips.
SmoothParts strip_compliance(const LayerTable& table, double thickness, double distance, double width);

}  // namespace tactel::fem
