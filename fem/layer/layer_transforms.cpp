// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_transforms.h"

#include <Eigen/Dense>
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

/// Y, B and S of one layer by |w| = 1.
struct Slab {
  Slab(const RubberLayer& layer, double a) {
    const double nu = layer.poisson, G = layer.young / (2 * (1 + nu)), part = 2 * (1 - nu);
    const Terms t(nu, a);
    const LayerTransforms single = layer_transforms(nu, a);
    Y << part * single.xx, single.xy, single.xy, part * single.yy;
    Y /= 2 * G;
    B << single.tau_by_x, -single.tau_by_y, single.sigma_by_x, single.sigma_by_y;
    const double bent = 2 * a * t.inverse, q = t.compressible * t.cosh_2a_less_1 + a * bent;
    S << part * (t.sinh_2a + bent), q, q, part * (t.sinh_2a - bent);
    S *= 2 * G / t.D;
  }
  Eigen::Matrix2d Y, B, S;
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

StackTransforms stack_transforms(std::span<const RubberLayer> layers, double a, int below) {
  double thickness = 0, across = 0, across_base = 1;
  for (const RubberLayer& layer : layers) thickness += layer.thickness;
  Eigen::Matrix2d Y = Eigen::Matrix2d::Zero(), B = Eigen::Matrix2d::Identity();
  for (const RubberLayer& layer : layers) {
    const double height = a * layer.thickness / thickness, G = layer.young / (2 * (1 + layer.poisson));
    const Slab slab(layer, height);
    const Eigen::Matrix2d X = (Eigen::Matrix2d::Identity() + slab.S * Y).inverse() * slab.B;
    Y = (slab.Y + slab.B.transpose() * Y * X).eval();
    B = (B * X).eval();
    const double even = 1 / std::cosh(height), odd = std::tanh(height), passed = even / (1 + G * odd * across);
    across = odd / G + even * across * passed;
    across_base *= passed;
    if (--below >= 0) B.setIdentity(), across_base = 1;
  }
  const double nu = layers.back().poisson, G = layers.back().young / (2 * (1 + nu));
  return {.plane = {.yy = Y(1, 1) * G / (1 - nu),
                    .xx = Y(0, 0) * G / (1 - nu),
                    .xy = 2 * G * Y(0, 1),
                    .sigma_by_y = B(1, 1),
                    .tau_by_x = B(0, 0),
                    .tau_by_y = -B(0, 1),
                    .sigma_by_x = B(1, 0)},
          .across = across * G,
          .across_base = across_base};
}

}  // namespace tactel::fem
