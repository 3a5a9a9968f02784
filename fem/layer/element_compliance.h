// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

#include "fem/layer/layer_table.h"

namespace tactel::fem {

/// Compliance of equal elements side by side on the layer, each with constant pressure and traction; displacement
/// is taken at the elements' middles, the unknowns are the elements' forces (N/mm). Index k is the place of the
/// displacement less that of the force, in elements; k >= 0 is stored. For E = 1 MPa:
///     u_y by f_y = yy[|k|],   u_x by f_x = xx[|k|],   u_x by f_y = sgn(k) xy[|k|],   u_y by f_x = -sgn(k) xy[|k|].
struct ElementCompliance {
  Eigen::VectorXd yy, xx, xy;  ///< [elements] mm/(N/mm)
};

/// Returns the compliance of `elements` elements of `width` mm on a layer of `thickness` mm.
///
/// With the width d and R of the table (layer_kernels.h):
///     yy[k] = cy (-ln(d/h) - c_k + (R((k + 1/2) d) - R((k - 1/2) d)) / d)            xx alike
///     xy[k] = cx ((1 - 2 nu) (pi/2) sgn k + (Rxy((k + 1/2) d) - Rxy((k - 1/2) d)) / d),    R at x / h
///     c_k = (k + 1/2) ln|k + 1/2| - (k - 1/2) ln|k - 1/2| - 1
/// The singular part is exact, so that elements may be as small as they like.
ElementCompliance element_compliance(const LayerTable& table, double thickness, double width, int elements);

/// Returns c_k, the mean of ln|x| over an element of width 1 at distance k.
double mean_logarithm(int k);

}  // namespace tactel::fem
