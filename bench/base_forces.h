#pragma once
#include <cmath>

#include "fem/contact_solution.h"

namespace tactel::bench {

/// Largest difference of base forces over the largest normal one, over all steps; not finite where an answer is not.
inline double base_force_difference(const fem::ContactSolution& a, const fem::ContactSolution& b) {
  if (a.steps.size() != b.steps.size()) return INFINITY;
  double worst = 0;
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    const double scale = b.steps[k].base_force_y.cwiseAbs().maxCoeff();
    for (auto force : {&fem::ContactStep::base_force_x, &fem::ContactStep::base_force_y}) {
      const double off = (a.steps[k].*force - b.steps[k].*force).cwiseAbs().maxCoeff<Eigen::PropagateNaN>() / scale;
      if (!(off <= worst)) worst = off;
      if (std::isnan(worst)) return worst;
    }
  }
  return worst;
}

}  // namespace tactel::bench
