// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <string>
#include <vector>

#include "fem/indenter.h"

namespace tactel::fem {

/// Derivative of a profile's heights by one of its numbers.
struct HeightDerivative {
  std::string key;         ///< as in scene files, such as "radius" or "coefficients[1]"
  double value = 0;        ///< of the number
  std::string unit;        ///< of the number; empty: none
  Eigen::VectorXd height;  ///< [places] mm over that unit; 0 beyond the indenter
};

/// Returns the derivatives of profile_heights at x [places] mm by every number of the shape that moves no edge of the
/// indenter: not the half_width of `flat`. A measured profile has none. At a corner of the profile (r = half_width) the
/// derivative is that from inside.
std::vector<HeightDerivative> height_derivatives(const Indenter& indenter, const Eigen::VectorXd& x);

}  // namespace tactel::fem
