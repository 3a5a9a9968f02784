// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Sparse>

#include "fem/mesh/mesh.h"

namespace tactel::fem {

/// Returns the stiffness of the whole block, base included, without constraints: [2 nodes, 2 nodes], N/mm per mm
/// of depth, symmetric, both triangles stored.
Eigen::SparseMatrix<double> stiffness(const Mesh& mesh, const Sensor& sensor);

/// Returns the map from base nodal forces to stress at the tactels, `reaction` recovery: the consistent mass of
/// the base edge, then the interpolation of the edge. [tactels, base nodes] 1/mm. The map is the same for sigma_y
/// from forces in y and for tau_xy from forces in x.
Eigen::MatrixXd base_stress_from_reaction(const Mesh& mesh, const Sensor& sensor);

/// Returns the map from all displacements to stress at the tactels, `element` recovery: Gauss stresses
/// extrapolated, averaged at the base nodes, then interpolated along the edge. [2 tactels, 2 nodes] MPa/mm:
/// sigma_y of every tactel first, then tau_xy.
Eigen::SparseMatrix<double> base_stress_from_elements(const Mesh& mesh, const Sensor& sensor);

/// Returns the stress inside the block for displacements [2 nodes], extrapolated from Gauss points and averaged
/// at nodes. [4, nodes] MPa: rows sigma_x, sigma_y, tau_xy, sigma_z.
Eigen::Matrix4Xd nodal_stress(const Mesh& mesh, const Sensor& sensor, const Eigen::VectorXd& displacement);

/// Returns x of the middles of the tactels, [tactels] mm.
Eigen::VectorXd tactel_positions(const Sensor& sensor);

}  // namespace tactel::fem
