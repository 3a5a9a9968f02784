#pragma once
#include <Eigen/Dense>
#include <filesystem>

#include "fem/sensor.h"

namespace tactel::fem {

/// All that contact can ask of the block. A surface load is [2 columns]: force on the rubber at surface node i,
/// x at 2i and y at 2i + 1 (y up: pressure is negative), N/mm.
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

/// The same through a file cache: `directory` holds one file a key; the key is made of all that the result depends on
/// (not E) and of a format version. A damaged, truncated or foreign file is detected by checksum and rebuilt. Files are
/// written to a temporary name, then renamed. An unwritable directory costs the caching, not the answer.
Condensation condense_cached(const Sensor& sensor, const std::filesystem::path& directory);

/// $TACTEL_CACHE_DIR, else $XDG_CACHE_HOME/tactel, else $HOME/.cache/tactel.
std::filesystem::path default_cache_directory();

/// Displacements of all nodes [2 nodes] mm under a surface load [2 columns] N/mm, by a fresh solve of the full block.
Eigen::VectorXd block_displacement(const Sensor& sensor, const Eigen::VectorXd& surface_load);

}  // namespace tactel::fem
