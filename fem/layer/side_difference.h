// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <filesystem>

#include "fem/scenes/sensor.h"

namespace tactel::fem {

/// The mesh of the block has no stiffness at 1/2. Half a millimetre from an end S at 1/2 is off by some 2e-4 for it,
/// in the middle by nothing.
inline constexpr double most_poisson_of_block = 0.49999;

/// What the free sides of a block change: the block less an endless layer on the same mesh, so that the singular part
/// and the mesh's own error cancel. It is smooth, and small farther than some 4 thicknesses from the ends. E = 1 MPa.
struct SideDifference {
  double thickness = 0;        ///< mm
  Eigen::VectorXd x;           ///< [nodes] mm: surface nodes between the block's ends, without those at the ends
  Eigen::MatrixXd compliance;  ///< [2 nodes, 2 nodes] mm/(N/mm), symmetric; x at 2i, y at 2i + 1
  Eigen::VectorXd base_x;      ///< [base nodes] mm
  Eigen::MatrixXd base;  ///< [2 base nodes, 2 nodes] 1/mm: tau_xy at 2k and sigma_y at 2k + 1, by `reaction`, each
                         ///< force spread over three nodes as (1, 2, 1)/4: nodal reactions of bbar near nu = 1/2
                         ///< wiggle from node to node
};

/// Longest block, in thicknesses; sides that are farther apart do not feel each other.
inline constexpr double longest_side_block = 24;

/// Returns the block on which the sides of a sensor are computed: its thickness and poisson, its length up to
/// `longest_side_block`, 12 columns to a thickness (at least 41) and 25 rows of bbar.
Sensor side_block(const Sensor& sensor);

/// Condenses the block through the cache of fem/mesh/condensation.h.
SideDifference side_difference(const Sensor& side_block, const std::filesystem::path& cache_directory);

}  // namespace tactel::fem
