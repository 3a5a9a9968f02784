// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/element_compliance.h"

#include <cmath>
#include <numbers>

namespace tactel::fem {

double mean_logarithm(int k) {
  const double right = k + 0.5, left = k - 0.5;
  return right * std::log(right) - left * std::log(std::abs(left)) - 1;
}

ElementCompliance element_compliance(const LayerTable& table, double thickness, double width, int elements) {
  const double nu = table.poisson(), d = width / thickness, log = std::log(d);
  const double cy = layer_cy(nu), cx = layer_cx(nu), jump = (1 - 2 * nu) * std::numbers::pi / 2;
  ElementCompliance c{Eigen::VectorXd(elements), Eigen::VectorXd(elements), Eigen::VectorXd(elements)};
  SmoothParts left = table.smooth_integral(-d / 2);
  for (int k = 0; k < elements; ++k) {
    const SmoothParts right = table.smooth_integral((k + 0.5) * d);
    const double singular = -log - mean_logarithm(k);
    c.yy[k] = cy * (singular + (right.yy - left.yy) / d);
    c.xx[k] = cy * (singular + (right.xx - left.xx) / d);
    c.xy[k] = k == 0 ? 0 : cx * (jump + (right.xy - left.xy) / d);
    left = right;
  }
  return c;
}

}  // namespace tactel::fem
