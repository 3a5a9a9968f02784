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

LayerTransforms layer_transforms_by_poisson(double poisson, double a) {
  const double k = 3 - 4 * poisson, compressible = 1 - 2 * poisson, p = 4 * (1 - poisson);
  const double inverse = std::exp(-2 * a);
  const double sinh_2a = -std::expm1(-4 * a) / 2, cosh_2a = (1 + inverse * inverse) / 2;
  const double cosh_2a_less_1 = std::expm1(-2 * a) * std::expm1(-2 * a) / 2;
  const double sinh_a = -std::exp(-a) * std::expm1(-2 * a) / 2, cosh_a = std::exp(-a) * (1 + inverse) / 2;
  const double D = k * cosh_2a + (2 * a * a + 1 + p * compressible) * inverse;
  const double D_change = -4 * (cosh_2a + k * inverse);
  const LayerTransforms t = layer_transforms(poisson, a);
  const auto quotient = [&](double value, double numerator_change) {
    return (numerator_change - value * D_change) / D;
  };
  // The numerators' own: dk = -4, d(1 - 2 nu) = -2, dp = -4. Where p is a factor, -4 / p of the value and p times the
  // rest.
  const auto with_p = [&](double value, double rest) { return quotient(value, -4 / p * value * D + p * rest); };
  return {.yy = quotient(t.yy, -4 * sinh_2a),
          .xx = quotient(t.xx, -4 * sinh_2a),
          .xy = quotient(t.xy, (-2 * k - 4 * compressible) * cosh_2a_less_1),
          .sigma_by_y = with_p(t.sigma_by_y, -2 * cosh_a),
          .tau_by_x = with_p(t.tau_by_x, -2 * cosh_a),
          .tau_by_y = with_p(t.tau_by_y, 2 * sinh_a),
          .sigma_by_x = with_p(t.sigma_by_x, -2 * sinh_a)};
}

}  // namespace tactel::fem
