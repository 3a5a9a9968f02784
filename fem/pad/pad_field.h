// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>

#include "fem/pad/pad_solver.h"

namespace tactel::fem {

/// Displacement and stress within the rubber of a pad under the tractions of a contact: those of an endless layer,
/// bonded at z = 0. Points lie in levels from the base to the surface, which come closer towards the surface, x
/// fastest, then y, then z.
struct PadField {
  std::array<int, 3> points{};                      ///< along the indenter's own x and y, and z
  Eigen::Matrix3Xd place;                           ///< mm, on the pad
  Eigen::Matrix3Xd displacement;                    ///< mm
  Eigen::Matrix<double, 6, Eigen::Dynamic> stress;  ///< MPa, tension > 0: xx, yy, zz, xy, yz, xz, in the pad's frame
};

/// Each number is the mean over half a cell along x and y. The tractions repeat in ten thicknesses, and their
/// mean bears on all of that square: 3e-3 of the largest pressure at most. Cells below a
/// twentieth of a thickness count as such. Throws ValueError, key "sides", for a pad with free
/// sides, which bound no endless layer, and "sensor.layers" for layers upon layers.
PadField pad_field(const PadScene& scene, const PadSolution& solution, std::size_t step);

}  // namespace tactel::fem
