// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/strip_compliance.h"

#include <cmath>
#include <numbers>

namespace tactel::fem {
namespace {

/// int_0^y ln|x| dx.
double log_integral(double y) { return y == 0 ? 0 : y * std::log(std::abs(y)) - y; }

}  // namespace

SmoothParts strip_compliance(const LayerTable& table, double thickness, double distance, double width) {
  const double nu = table.poisson(), d = width / thickness;
  const double right = (distance + width / 2) / thickness, left = (distance - width / 2) / thickness;
  const SmoothParts to = table.smooth_integral(right), from = table.smooth_integral(left);
  const double singular = -(log_integral(right) - log_integral(left));
  const double jump = (1 - 2 * nu) * std::numbers::pi / 2 * (std::abs(right) - std::abs(left));
  return {layer_cy(nu) * (singular + to.yy - from.yy) / d, layer_cy(nu) * (singular + to.xx - from.xx) / d,
          layer_cx(nu) * (jump + to.xy - from.xy) / d};
}

}  // namespace tactel::fem
