// SPDX-License-Identifier: Apache-2.0

// The closed transforms against the layer's boundary-value problem, solved here as four equations for four
// exponentials.
#include "fem/layer/layer_transforms.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <complex>

namespace tactel::fem::layer_transforms_test {

using Complex = std::complex<long double>;
using Vector4 = Eigen::Matrix<Complex, 4, 1>;

/// One of the four solutions of Navier's equations that go like e^(iwx): displacement and stress at height y.
struct Solution {
  Complex ux, uy, sigma_y, tau;
};

/// E = 1, h = 1. `s` = +w or -w; potentials of Papkovich and Neuber: u = grad phi for `moment` 0, u = y grad phi -
/// (3 - 4 nu) phi e_y for 1, with phi = e^(iwx + s y), scaled so that its largest value in the layer is 1.
Solution exponential(long double nu, long double w, long double s, int moment, long double y) {
  const Complex i(0, 1);
  const long double shear = 1 / (2 * (1 + nu)), phi = std::exp(s * (s > 0 ? y - 1 : y)), k = 3 - 4 * nu;
  if (moment == 0) return {i * w * phi, s * phi, 2 * shear * s * s * phi, 2 * shear * i * w * s * phi};
  const Complex ux = y * i * w * phi, uy = (y * s - k) * phi;
  // lambda div u = nu / ((1 + nu) (1 - 2 nu)) * (1 - k) s phi: finite at nu = 1/2.
  const long double pressure = -2 * nu / (1 + nu) * s * phi;
  const Complex duy_dy = (s + y * s * s - k * s) * phi, dux_dy = i * w * (1 + y * s) * phi;
  return {ux, uy, pressure + 2 * shear * duy_dy, shear * (dux_dy + i * w * uy)};
}

/// The layer under the surface force (fx, fy) e^(iwx): displacement at the surface and stress at the base.
Solution layer(long double nu, long double w, Complex fx, Complex fy) {
  Eigen::Matrix<Complex, 4, 4> conditions;  // u_x, u_y at the base; tau, sigma_y at the surface
  for (int j = 0; j < 4; ++j) {
    const long double s = j < 2 ? w : -w;
    const Solution base = exponential(nu, w, s, j % 2, 0), surface = exponential(nu, w, s, j % 2, 1);
    conditions.col(j) << base.ux, base.uy, surface.tau, surface.sigma_y;
  }
  const Vector4 share = conditions.fullPivLu().solve(Vector4(0, 0, fx, fy));
  Solution sum{};
  for (int j = 0; j < 4; ++j) {
    const long double s = j < 2 ? w : -w;
    const Solution base = exponential(nu, w, s, j % 2, 0), surface = exponential(nu, w, s, j % 2, 1);
    sum.ux += share[j] * surface.ux;
    sum.uy += share[j] * surface.uy;
    sum.sigma_y += share[j] * base.sigma_y;
    sum.tau += share[j] * base.tau;
  }
  return sum;
}

class Transforms : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(Transforms, SolveTheBoundaryValueProblem) {
  const auto [nu, a] = GetParam();
  const LayerTransforms t = layer_transforms(nu, a);
  // The conditions of the four exponentials grow with a and as nu nears 1/2, where rounding of e^a sqrt(D) is left.
  const double tolerance = nu > 0.49 && a > 3 ? 1e-10 : 1e-12;
  const double cy = 2 * (1 - nu * nu) / a, cx = (1 + nu) / a;
  for (const double w : {a, -a}) {
    const Complex i(0, w > 0 ? 1 : -1);  // i sgn w
    const Solution by_y = layer(nu, w, 0, 1), by_x = layer(nu, w, 1, 0);
    const auto near = [&](Complex found, Complex wanted, const char* what) {
      EXPECT_LT(std::abs(found - wanted), tolerance * std::max(1.0L, std::abs(wanted))) << what << " w " << w;
    };
    near(Complex(cy * t.yy), by_y.uy, "u_y by f_y");
    near(Complex(cy * t.xx), by_x.ux, "u_x by f_x");
    near(-i * Complex(cx * t.xy), by_y.ux, "u_x by f_y");
    near(i * Complex(cx * t.xy), by_x.uy, "u_y by f_x");
    near(Complex(t.sigma_by_y), by_y.sigma_y, "sigma_y by f_y");
    near(Complex(t.tau_by_x), by_x.tau, "tau by f_x");
    near(i * Complex(t.tau_by_y), by_y.tau, "tau by f_y");
    near(i * Complex(t.sigma_by_x), by_x.sigma_y, "sigma_y by f_x");
  }
}
INSTANTIATE_TEST_SUITE_P(PoissonAndWavenumber, Transforms,
                         testing::Combine(testing::Values(0.0, 0.3, 0.45, 0.49, 0.499, 0.5),
                                          testing::Values(0.05, 0.5, 1.0, 2.5, 6.0)));

TEST(LayerTransforms, LongWavesPressAndShearColumns) {
  // u_y = sigma h (1 + nu) (1 - 2 nu) / (E (1 - nu)), u_x = tau h 2 (1 + nu) / E; stress reaches the base unchanged.
  constexpr double a = 1e-5;
  for (const double nu : {0.0, 0.3, 0.45, 0.499}) {
    const LayerTransforms t = layer_transforms(nu, a);
    const double cy = 2 * (1 - nu * nu) / a;
    EXPECT_NEAR(cy * t.yy, (1 + nu) * (1 - 2 * nu) / (1 - nu), 1e-9) << nu;
    EXPECT_NEAR(cy * t.xx, 2 * (1 + nu), 1e-8) << nu;
    EXPECT_NEAR(t.sigma_by_y, 1, 1e-9) << nu;
    EXPECT_NEAR(t.tau_by_x, 1, 1e-9) << nu;
    EXPECT_NEAR(t.tau_by_y, 0, 1e-4) << nu;
    EXPECT_NEAR(t.sigma_by_x, 0, 1e-4) << nu;
  }
}

TEST(LayerTransforms, ThickLayerIsAHalfPlane) {
  for (const double nu : {0.0, 0.45, 0.5}) {
    for (const double a : {40.0, 1000.0}) {
      const LayerTransforms t = layer_transforms(nu, a);
      EXPECT_NEAR(t.yy, 1, 1e-15);
      EXPECT_NEAR(t.xx, 1, 1e-15);
      EXPECT_NEAR(t.xy, 1 - 2 * nu, 1e-15);
      EXPECT_NEAR(t.sigma_by_y, 0, 1e-14);
    }
  }
}

}  // namespace tactel::fem::layer_transforms_test
