// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/frictionless_pressing.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {

Eigen::VectorXd frictionless_pressing(const Eigen::VectorXd& compliance, const Eigen::VectorXd& gap, double tolerance,
                                      int most_sweeps) {
  const Eigen::Index elements = gap.size();
  Eigen::VectorXd n = Eigen::VectorXd::Zero(elements);
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double change = 0;
    for (Eigen::Index i = 0; i < elements; ++i) {
      double opening = gap[i];
      for (Eigen::Index j = 0; j < elements; ++j) opening += compliance[std::abs(i - j)] * n[j];
      const double pressed = std::max(0.0, n[i] - opening / compliance[0]);
      change = std::max(change, std::abs(pressed - n[i]));
      n[i] = pressed;
    }
    if (change <= tolerance * n.maxCoeff()) break;
  }
  return n;
}

}  // namespace tactel::fem
