// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <filesystem>

#include "fem/scenes/sensor.h"

namespace tactel::fem {

/// The block as seen by the contact. A surface load is [2 columns]: force on the rubber at surface node i, x at
/// 2i and y at 2i + 1 (y up: pressure is negative), N/mm.
struct Condensation {
  Eigen::MatrixXd
      compliance;  ///< C [2 columns, 2 columns] mm/(N/mm) for E = 1 MPa: displacement of the surface nodes = C load / E
  Eigen::MatrixXd base_force;  ///< T [2 base nodes, 2 columns]: force of the rubber on the base = T load (x at 2k, y at
                               ///< 2k + 1), free of E
  Eigen::MatrixXd tactel_stress;  ///< [2 tactels, 2 columns] 1/mm: sigma_y of every tactel, then tau_xy, MPa per N/mm,
                                  ///< by the sensor's recovery, free of E
  Eigen::VectorXd surface_x;      ///< [columns] mm
  Eigen::VectorXd base_x;         ///< [base nodes] mm
  Eigen::VectorXd tactel_x;       ///< [tactels] mm
};

/// Factors the block in fp64 (sparse Cholesky, base clamped) and solves for the surface columns.
Condensation condense(const Sensor& sensor);

/// Returns the largest share of a unit load, in x or y, that T does not transmit to the base: the effect of
/// rounding of the assembled stiffness near nu = 1/2. It is some 1e-14 up to nu = 0.45; above 1e-7 condense
/// throws.
double lost_force(const Condensation& condensation);

/// The same through a file cache. `directory` holds one file a key. The key contains all inputs of the result
/// (not E) and a format version. A damaged, truncated or foreign file is detected by its checksum and rebuilt.
/// Files are written under a temporary name, then renamed. In an unwritable directory nothing is cached, and the
/// answer is the same.
Condensation condense_cached(const Sensor& sensor, const std::filesystem::path& directory);

}  // namespace tactel::fem
