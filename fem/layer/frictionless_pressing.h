// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

namespace tactel::fem {

/// Returns the pressure forces of equal elements without friction, over E: [elements] mm. `compliance` is
/// ElementCompliance::yy, [elements]; `gap` is the profile's height less the depth, [elements] mm. Gauss-Seidel
/// from zero forces, left to right: n_i = max(0, n_i - (sum_j c_|i-j| n_j + gap_i) / c_0), until no force of a
/// sweep changes by more than `tolerance` times the largest, at most `most_sweeps` times.
Eigen::VectorXd frictionless_pressing(const Eigen::VectorXd& compliance, const Eigen::VectorXd& gap, double tolerance,
                                      int most_sweeps);

}  // namespace tactel::fem
