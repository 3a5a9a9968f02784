// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

#include "fem/scenes/sensor.h"

namespace tactel::fem {

/// An endless layer on a finite element mesh with equal columns: what a unit force on one surface node does at the
/// nodes k columns to its right, k = 0, 1, ...; the layer of layer_kernels.h with a mesh's errors. E = 1 MPa.
struct LongLayer {
  double spacing = 0;          ///< mm between columns
  Eigen::VectorXd yy, xx, xy;  ///< mm/(N/mm): u_y by f_y and u_x by f_x (even in k), u_x by f_y (odd)
  Eigen::VectorXd sigma_by_y, tau_by_x, tau_by_y, sigma_by_x;  ///< 1/mm: base stress at the base nodes, by `reaction`
                                                               ///< (block.h); the first two even, the others odd
};

/// Returns the layer on the mesh of this sensor (thickness, rows, grading, spacing of columns, element, poisson),
/// for k up to `columns`. The mesh is the same from column to column: for each wavenumber of a period that is longer
/// by far than the answers reach, its stiffness is one column's, of 2 (rows - 1) unknowns (Bloch's theorem). Elements
/// with mid-side nodes (q8) throw std::invalid_argument.
LongLayer long_layer(const Sensor& sensor, int columns);

}  // namespace tactel::fem
