// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

#include "fem/scenes/sensor.h"

namespace tactel::fem {

/// Isotropic linear elasticity, MPa.
struct Material {
  double shear;  ///< G = E / (2 (1 + nu))
  double bulk;   ///< kappa = E / (3 (1 - 2 nu))
};
/// Returns that of the rubber at a height, mm.
Material material(const Sensor& sensor, double height = 0);

using ElementNodes = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 8>;                     ///< [2, 4 or 8] mm
using ElementStiffness = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 16, 16>;  ///< [2 nodes, 2 nodes]
using ElementStress = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 32, 16>;     ///< [4 nodes, 2 nodes]

/// Returns the number of nodes of an element: 8 for q8, else 4.
int nodes_per_element(Element element);

/// Returns the stiffness in plane strain, N/mm per mm of depth, exactly symmetric. Local node k has displacements
/// 2k (x) and 2k + 1 (y). Nodes are ordered as in Mesh::cell; the element may be any convex quadrilateral.
ElementStiffness element_stiffness(Element element, const ElementNodes& node, const Material& material);

/// Returns the map from displacements to stress at the element's nodes, MPa/mm: computed at the 2x2 Gauss points,
/// extrapolated bilinearly. Rows 4k .. 4k + 3 are sigma_x, sigma_y, tau_xy, sigma_z at local node k.
ElementStress element_nodal_stress(Element element, const ElementNodes& node, const Material& material);

}  // namespace tactel::fem
