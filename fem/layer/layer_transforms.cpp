// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_transforms.h"

#include <cmath>

namespace tactel::fem {

namespace {

/// What the transforms and their derivatives are made of.
struct Terms {
  Terms(double poisson, double a)
      : k(3 - 4 * poisson),
        compressible(1 - 2 * poisson),
        p(4 * (1 - poisson)),
        inverse(std::exp(-2 * a)),
        sinh_2a(-std::expm1(-4 * a) / 2),
        cosh_2a((1 + inverse * inverse) / 2),
        cosh_2a_less_1(std::expm1(-2 * a) * std::expm1(-2 * a) / 2),
        sinh_a(-std::exp(-a) * std::expm1(-2 * a) / 2),
        cosh_a(std::exp(-a) * (1 + inverse) / 2),
        D(k * cosh_2a + (2 * a * a + 1 + p * compressible) * inverse) {}

  double k, compressible, p;
  double inverse;
  double sinh_2a, cosh_2a, cosh_2a_less_1, sinh_a, cosh_a;  ///< over exp(2a); differences without cancellation
  double D;                                                 ///< denominator of all transforms
};

}  // namespace

LayerTransforms layer_transforms(double poisson, double a) {
  const Terms t(poisson, a);
  const double even = 2 * (1 - poisson) * t.cosh_a, odd = t.compressible * t.sinh_a;
  return {.yy = (t.k * t.sinh_2a - 2 * a * t.inverse) / t.D,
          .xx = (t.k * t.sinh_2a + 2 * a * t.inverse) / t.D,
          .xy = (t.compressible * t.k * t.cosh_2a_less_1 - 2 * a * a * t.inverse) / t.D,
          .sigma_by_y = t.p * (even + a * t.sinh_a) / t.D,
          .tau_by_x = t.p * (even - a * t.sinh_a) / t.D,
          .tau_by_y = t.p * (a * t.cosh_a - odd) / t.D,
          .sigma_by_x = t.p * (a * t.cosh_a + odd) / t.D};
}

LayerTransforms layer_transforms_by_poisson(double poisson, double a) {
  const Terms t(poisson, a);
  const LayerTransforms value = layer_transforms(poisson, a);
  const double D_change = -4 * (t.cosh_2a + t.k * t.inverse);
  const auto quotient = [&](double transform, double numerator_change) {
    return (numerator_change - transform * D_change) / t.D;
  };
  // The numerators' own: dk = -4, d(1 - 2 nu) = -2, dp = -4. Where p is a factor, -4 / p of the value and p times the
  // rest.
  const auto with_p = [&](double transform, double rest) {
    return quotient(transform, -4 / t.p * transform * t.D + t.p * rest);
  };
  return {.yy = quotient(value.yy, -4 * t.sinh_2a),
          .xx = quotient(value.xx, -4 * t.sinh_2a),
          .xy = quotient(value.xy, (-2 * t.k - 4 * t.compressible) * t.cosh_2a_less_1),
          .sigma_by_y = with_p(value.sigma_by_y, -2 * t.cosh_a),
          .tau_by_x = with_p(value.tau_by_x, -2 * t.cosh_a),
          .tau_by_y = with_p(value.tau_by_y, 2 * t.sinh_a),
          .sigma_by_x = with_p(value.sigma_by_x, -2 * t.sinh_a)};
}

}  // namespace tactel::fem
