// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/slip_margin.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {
namespace {

// A cell at the centre of rotation would weigh infinitely.
constexpr double least_slip = 1e-9;
constexpr double least_wrench = 1e-6;

}  // namespace

double slip_margin(const Eigen::MatrixX2d& places, const Eigen::VectorXd& grip, const Eigen::Vector3d& wrench,
                   int rounds) {
  const double total = grip.sum();
  if (!(total > 0)) return 0;
  // About the pressure's centre, lengths over the radius of gyration, forces over the grip.
  const Eigen::RowVector2d centre = grip.transpose() * places / total;
  Eigen::MatrixX2d r = places.rowwise() - centre;
  const double gyration = std::sqrt(grip.dot(r.rowwise().squaredNorm()) / total);
  const double length = gyration > 0 ? gyration : 1;
  r /= length;
  const double moment = wrench[2] - (centre[0] * wrench[1] - centre[1] * wrench[0]);
  const Eigen::Vector3d W(wrench[0] / total, wrench[1] / total, moment / (length * total));
  if (!(W.norm() > least_wrench)) return 0;
  Eigen::Vector3d twist = W / W.squaredNorm();
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round <= rounds; ++round) {
    Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
    double lambda = 0;
    for (Eigen::Index i = 0; i < grip.size(); ++i) {
      if (!(grip[i] > 0)) continue;
      const double x = r(i, 0), y = r(i, 1), g = grip[i] / total;
      const double slip = std::hypot(twist[0] - twist[2] * y, twist[1] + twist[2] * x);
      lambda += g * slip;
      const double weight = g / std::max(slip, least_slip);
      K(0, 0) += weight;
      K(0, 2) -= weight * y;
      K(1, 2) += weight * x;
      K(2, 2) += weight * (x * x + y * y);
    }
    least = std::min(least, lambda);
    K(1, 1) = K(0, 0);
    K(2, 0) = K(0, 2);
    K(2, 1) = K(1, 2);
    // All grip in one place bears no moment: its row vanishes.
    if (!(K(2, 2) > 0)) K(2, 2) = least_slip;
    const Eigen::Vector3d z = K.ldlt().solve(W);
    twist = z / W.dot(z);
  }
  return 1 / least;
}

}  // namespace tactel::fem
