// SPDX-License-Identifier: Apache-2.0

// Kernels, tables and element compliance against values of an independent program (numpy, adaptive quadrature of
// transforms that were found by a 4 x 4 solve), and against integrals that are known.
#include "fem/layer/layer_table.h"

#include <gtest/gtest.h>

#include "fem/layer/element_compliance.h"

namespace tactel::fem::layer_table_test {

constexpr double thickness = 1.5;  // mm

struct Reference {
  double nu;
  double yy[5], xx[5], xy[5];                                     // at 0.1, 0.5, 1, 2, 4 mm
  double c_yy[2], c_xx[2], c_xy[2];                               // elements of 0.1 mm, k = 0, 1
  double sigma_by_y[2], tau_by_y[2], sigma_by_x[2], tau_by_x[2];  // 1/mm, at 0, 1 mm
};
constexpr double place[] = {0.1, 0.5, 1, 2, 4};
constexpr Reference references[] = {{0.3,
                                     {1.265590, 0.375757, 0.089673, -0.015721, -0.002808},
                                     {1.812442, 0.899624, 0.550367, 0.279635, 0.087205},
                                     {0.234943, 0.140081, 0.048787, -0.024971, -0.014034},
                                     {2.244784, 1.291944},
                                     {2.792543, 1.838714},
                                     {0, 0.234955},
                                     {.53856, .20438},
                                     {0, -.13436},
                                     {0, -.20737},
                                     {.08230, .17408}},
                                    {0.45,
                                     {0.967760, 0.197945, -0.027116, -0.066069, -0.016816},
                                     {1.689127, 0.890535, 0.586467, 0.340885, 0.126530},
                                     {0.051271, -0.027600, -0.095897, -0.118856, -0.046695},
                                     {1.825497, 0.990893},
                                     {2.548001, 1.712156},
                                     {0, 0.051284},
                                     {.54206, .18996},
                                     {0, -.18157},
                                     {0, -.20204},
                                     {.02506, .16108}},
                                    {0.499,
                                     {0.831967, 0.112346, -0.086030, -0.094632, -0.027111},
                                     {1.628011, 0.877105, 0.592947, 0.360692, 0.141508},
                                     {-0.018761, -0.093355, -0.154452, -0.158839, -0.062769},
                                     {1.639477, 0.853770},
                                     {2.436758, 1.649702},
                                     {0, -0.018747},
                                     {.54888, .18305},
                                     {0, -.20203},
                                     {0, -.20247},
                                     {.00055, .15727}}};
constexpr double last_digit = 0.6e-6, last_base_digit = 0.6e-5;

void PrintTo(const Reference& r, std::ostream* out) { *out << "nu " << r.nu; }

class LayerOf : public testing::TestWithParam<Reference> {};

TEST_P(LayerOf, KernelsMatchReference) {
  const Reference& r = GetParam();
  const LayerKernels kernels(r.nu);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(kernels.displacement_yy(place[i] / thickness), r.yy[i], last_digit) << place[i];
    EXPECT_NEAR(kernels.displacement_xx(place[i] / thickness), r.xx[i], last_digit) << place[i];
    EXPECT_NEAR(kernels.displacement_xy(place[i] / thickness), r.xy[i], last_digit) << place[i];
  }
  for (int i = 0; i < 2; ++i) {
    const BaseStress base = kernels.at(i / thickness).base;
    EXPECT_NEAR(base.sigma_by_y / thickness, r.sigma_by_y[i], last_base_digit);
    EXPECT_NEAR(base.tau_by_y / thickness, r.tau_by_y[i], last_base_digit);
    EXPECT_NEAR(base.sigma_by_x / thickness, r.sigma_by_x[i], last_base_digit);
    EXPECT_NEAR(base.tau_by_x / thickness, r.tau_by_x[i], last_base_digit);
  }
}

TEST_P(LayerOf, ElementsMatchReference) {
  const Reference& r = GetParam();
  const LayerTable table(r.nu, 4);
  const ElementCompliance c = element_compliance(table, thickness, 0.1, 2);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(c.yy[k], r.c_yy[k], 2 * last_digit);  // and 1e-6 of the table
    EXPECT_NEAR(c.xx[k], r.c_xx[k], 2 * last_digit);
    EXPECT_NEAR(c.xy[k], r.c_xy[k], 2 * last_digit);
  }
}

TEST_P(LayerOf, TableMatchesKernels) {
  // Cubics err by (1/24)^4 / 384 = 8e-9 times the fourth derivative: below 4 for R, 100 for the stresses, 20 for their
  // integrals.
  const LayerKernels kernels(GetParam().nu);
  const LayerTable table(GetParam().nu, 12);
  for (double x = 0.013; x < 12; x += 0.37) {
    const LayerKernelValues exact = kernels.at(x);
    for (const double side : {1, -1}) {
      SCOPED_TRACE(side * x);
      const SmoothParts R = table.smooth_integral(side * x);
      EXPECT_NEAR(R.yy, side * exact.smooth_integral.yy, 3e-8);
      EXPECT_NEAR(R.xx, side * exact.smooth_integral.xx, 3e-8);
      EXPECT_NEAR(R.xy, exact.smooth_integral.xy, 3e-8);
      const BaseStress base = table.base(side * x), integral = table.base_integral(side * x);
      EXPECT_NEAR(base.sigma_by_y, exact.base.sigma_by_y, 8e-7);
      EXPECT_NEAR(base.tau_by_x, exact.base.tau_by_x, 8e-7);
      EXPECT_NEAR(base.tau_by_y, side * exact.base.tau_by_y, 8e-7);
      EXPECT_NEAR(base.sigma_by_x, side * exact.base.sigma_by_x, 8e-7);
      EXPECT_NEAR(integral.sigma_by_y, side * exact.base_integral.sigma_by_y, 1.6e-7);
      EXPECT_NEAR(integral.tau_by_x, side * exact.base_integral.tau_by_x, 1.6e-7);
      EXPECT_NEAR(integral.tau_by_y, exact.base_integral.tau_by_y, 1.6e-7);
      EXPECT_NEAR(integral.sigma_by_x, exact.base_integral.sigma_by_x, 1.6e-7);
    }
  }
}

TEST_P(LayerOf, IntegralsAreThoseOfTheKernels) {
  // Simpson's rule over [1, 1.02] against the difference of the integrals.
  const LayerKernels kernels(GetParam().nu);
  const LayerKernelValues a = kernels.at(1), m = kernels.at(1.01), b = kernels.at(1.02);
  const auto simpson = [](double left, double middle, double right) { return (left + 4 * middle + right) / 300; };
  EXPECT_NEAR(b.smooth_integral.yy - a.smooth_integral.yy, simpson(a.smooth.yy, m.smooth.yy, b.smooth.yy), 1e-9);
  EXPECT_NEAR(b.smooth_integral.xx - a.smooth_integral.xx, simpson(a.smooth.xx, m.smooth.xx, b.smooth.xx), 1e-9);
  EXPECT_NEAR(b.smooth_integral.xy - a.smooth_integral.xy, simpson(a.smooth.xy, m.smooth.xy, b.smooth.xy), 1e-9);
  EXPECT_NEAR(b.base_integral.tau_by_y - a.base_integral.tau_by_y,
              simpson(a.base.tau_by_y, m.base.tau_by_y, b.base.tau_by_y), 1e-9);
  EXPECT_NEAR(b.base_integral.sigma_by_y - a.base_integral.sigma_by_y,
              simpson(a.base.sigma_by_y, m.base.sigma_by_y, b.base.sigma_by_y), 1e-9);
}

TEST_P(LayerOf, BaseCarriesTheForce) {
  const BaseStress half = LayerTable(GetParam().nu, 30).base_integral(30);
  EXPECT_NEAR(2 * half.sigma_by_y, 1, 1e-7);
  EXPECT_NEAR(2 * half.tau_by_x, 1, 1e-7);
}

TEST_P(LayerOf, FarAwayNothingMoves) {
  const double nu = GetParam().nu;
  const LayerKernels kernels(nu);
  EXPECT_NEAR(kernels.displacement_yy(35), 0, 1e-11);
  EXPECT_NEAR(kernels.displacement_xx(35), 0, 1e-11);
  EXPECT_NEAR(kernels.displacement_xy(35), 0, 1e-11);
  // Beyond its range the table goes on in closed form.
  const SmoothParts exact = kernels.at(38.3).smooth_integral, R = LayerTable(nu, 30).smooth_integral(38.3);
  EXPECT_NEAR(R.yy, exact.yy, 1e-7);
  EXPECT_NEAR(R.xx, exact.xx, 1e-7);
  EXPECT_NEAR(R.xy, exact.xy, 1e-7);
}
INSTANTIATE_TEST_SUITE_P(Poisson, LayerOf, testing::ValuesIn(references), [](const auto& info) {
  return "nu" + std::to_string(static_cast<int>(1000 * info.param.nu + 0.5));
});

TEST(LayerTable, IncompressibleLayerHasNoSingularCoupling) {
  // nu = 1/2: the layer's volume is constant, so that the uplift integrates to nothing, and u_x by f_y is continuous.
  const LayerTable table(0.5, 40);
  const ElementCompliance c = element_compliance(table, 1, 0.01, 3000);
  const double volume = c.yy[0] + 2 * c.yy.tail(2999).sum(), scale = c.yy.cwiseAbs().sum();
  EXPECT_NEAR(volume / scale, 0, 1e-5);
  EXPECT_NEAR(c.xy[1], 0, 2e-2);
}

TEST(ElementCompliance, UniformPressureOnAWideStripPressesAColumn) {
  // Elements over 40 h, all with the pressure 1 MPa: in their middle u = h (1 + nu) (1 - 2 nu) / (1 - nu), and
  // 2 (1 + nu) h for shear.
  constexpr double nu = 0.3, width = 0.2;
  constexpr int reach = 150;  // elements to either side
  const ElementCompliance c = element_compliance(LayerTable(nu), thickness, width, reach + 1);
  const double yy = c.yy[0] + 2 * c.yy.tail(reach).sum(), xx = c.xx[0] + 2 * c.xx.tail(reach).sum();
  EXPECT_NEAR(yy * width, thickness * (1 + nu) * (1 - 2 * nu) / (1 - nu), 1e-5);
  EXPECT_NEAR(xx * width, thickness * 2 * (1 + nu), 1e-5);
}

TEST(ElementCompliance, MeansOfTheLogarithm) {
  const double wanted[] = {-1.693147, -0.045229, 0.682529, 1.093944};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(mean_logarithm(k), wanted[k], 0.6e-6);
}

TEST(ElementCompliance, SmallElementsAreThoseOfAHalfPlane) {
  // Two elements of 2 um: differences of u_y are free of the layer, u_y[0] - u_y[1] = cy (c_1 - c_0).
  const LayerTable table(0.45, 4);
  const ElementCompliance c = element_compliance(table, thickness, 0.002, 2);
  EXPECT_NEAR(c.yy[0] - c.yy[1], layer_cy(0.45) * (mean_logarithm(1) - mean_logarithm(0)), 1e-6);
}

}  // namespace tactel::fem::layer_table_test
