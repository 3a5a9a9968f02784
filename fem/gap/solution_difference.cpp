// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/solution_difference.h"

#include <cmath>
#include <limits>

namespace tactel::fem {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// [2 base nodes]
Eigen::VectorXd base_force(const ContactStep& step) {
  Eigen::VectorXd force(step.base_force_x.size() + step.base_force_y.size());
  force << step.base_force_x, step.base_force_y;
  return force;
}

double relative_difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  if (a.size() != b.size()) return infinite;
  if (a.size() == 0) return 0;
  const double scale = b.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
  const double off = (a - b).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
  return off == 0 ? 0 : off / scale;
}

}  // namespace

double base_force_difference(const ContactSolution& a, const ContactSolution& b) {
  if (a.steps.size() != b.steps.size()) return infinite;
  double worst = 0;
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    const double off = relative_difference(base_force(a.steps[k]), base_force(b.steps[k]));
    if (std::isnan(off)) return off;
    worst = std::max(worst, off);
  }
  return worst;
}

}  // namespace tactel::fem
