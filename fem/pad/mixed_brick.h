// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

namespace tactel::fem {

/// A brick of 27 nodes with a pressure of its own, linear in x, y and z and eliminated: it does not lock near nu = 1/2,
/// and its stress converges at the second order (O. C. Zienkiewicz and R. L. Taylor, The Finite Element Method, 5th
/// ed., vol. 1, 2000, ch. 12). Nodes 9 i + 3 j + k along x, y, z; displacements x, y, z of each. E = 1.
class MixedBrick {
 public:
  static constexpr int unknowns = 81;

  /// Sides in one unit; 0 <= poisson < 1/2.
  MixedBrick(double hx, double hy, double hz, double poisson);

  /// [81][81].
  const Eigen::MatrixXd& stiffness() const { return stiffness_; }

  /// Stress on the lower face, tau_x, tau_y, sigma_z, at -1 <= x, y <= 1, by the displacements: [3][81].
  Eigen::MatrixXd face_stress(double x, double y) const;

 private:
  Eigen::Array3d sides_;
  double shear_;
  Eigen::MatrixXd stiffness_, pressure_;  ///< pressure: of 1, x, y, z, [4][81]
};

/// Values and slopes of the quadratics through -1, 0 and 1.
Eigen::Array3d quadratics(double at);
Eigen::Array3d quadratic_slopes(double at);

}  // namespace tactel::fem
