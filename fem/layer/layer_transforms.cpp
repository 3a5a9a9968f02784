// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_transforms.h"

#include <cmath>

namespace tactel::fem {

LayerTransforms layer_transforms(double poisson, double a) {
  const double k = 3 - 4 * poisson, compressible = 1 - 2 * poisson, p = 4 * (1 - poisson);
  // Hyperbolic functions over exp(2a); the differences are free of cancellation at small a.
  const double inverse = std::exp(-2 * a);
  const double sinh_2a = -std::expm1(-4 * a) / 2, cosh_2a = (1 + inverse * inverse) / 2;
  const double cosh_2a_less_1 = std::expm1(-2 * a) * std::expm1(-2 * a) / 2;
  const double sinh_a = -std::exp(-a) * std::expm1(-2 * a) / 2, cosh_a = std::exp(-a) * (1 + inverse) / 2;
  const double D = k * cosh_2a + (2 * a * a + 1 + p * compressible) * inverse;
  const double even = 2 * (1 - poisson) * cosh_a, odd = compressible * sinh_a;
  return {.yy = (k * sinh_2a - 2 * a * inverse) / D,
          .xx = (k * sinh_2a + 2 * a * inverse) / D,
          .xy = (compressible * k * cosh_2a_less_1 - 2 * a * a * inverse) / D,
          .sigma_by_y = p * (even + a * sinh_a) / D,
          .tau_by_x = p * (even - a * sinh_a) / D,
          .tau_by_y = p * (a * cosh_a - odd) / D,
          .sigma_by_x = p * (a * cosh_a + odd) / D};
}

}  // namespace tactel::fem
