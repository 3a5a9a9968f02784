// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_transforms.h"

#include <cmath>

namespace tactel::fem {

namespace {

/// What the transforms are made of.
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

}  // namespace tactel::fem
