// SPDX-License-Identifier: Apache-2.0

// How the elements converge, and which of them lock: compliance under a smooth pressure, against a fine q8 mesh.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "fem/mesh/clamped_block.h"
#include "sensors.h"
#include "surface_load.h"

namespace tactel::fem::refinement_test {

/// Twice the energy, load . displacement, of the sensor under pressure exp(-x^2) MPa (and half of it in shear), N/mm *
/// mm per mm of depth. The corners, where stress is singular, feel exp(-100) of the pressure and little of what it
/// causes.
double compliance(const Sensor& sensor) {
  const ClampedBlock block(sensor);
  const Eigen::VectorXd load = consistent_surface_load(
      block.mesh(), [](double x) -> Eigen::Vector2d { return std::exp(-x * x) * Eigen::Vector2d(0.5, -1); });
  return load.dot(block.displacement(load).col(0));
}

/// The rubber with 10 * 2^level + 1 columns and 2^level + 1 rows (level 2 is about mesh B, half as deep in rows).
Sensor refined(Element element, double poisson, int level) {
  Sensor sensor = mesh_b(element, poisson);
  sensor.columns = 10 * (1 << level) + 1;
  sensor.rows = (1 << level) + 1;
  return sensor;
}

/// q8 on 320 x 32 cells. Going on at the order that q8 shows, its own error is below 1e-6 for nu <= 0.45 and about 1e-4
/// at 0.4999, where q8 has not reached its order yet.
double reference(double poisson) { return compliance(refined(Element::q8, poisson, 5)); }

/// Relative errors at levels 2, 3 and 4, printed as a line of a table; orders are logarithms of their ratios.
std::vector<double> errors(Element element, double poisson, double exact) {
  std::vector<double> error;
  std::printf("%-5s nu = %-6g", name(element), poisson);
  for (int level : {2, 3, 4}) {
    error.push_back(std::abs(compliance(refined(element, poisson, level)) / exact - 1));
    std::printf("  %8.1e", error.back());
    if (level > 2) std::printf(" (order %4.2f)", std::log2(error[error.size() - 2] / error.back()));
  }
  std::printf("\n");
  return error;
}

class Refinement : public testing::TestWithParam<Element> {};

TEST_P(Refinement, ConvergesAtTheElementsOrder) {
  // Energy converges at twice the order of strains: 2 for the four-node elements, 4 for q8.
  const double order = GetParam() == Element::q8 ? 4 : 2;
  for (double nu : {0.3, 0.45}) {
    const std::vector<double> error = errors(GetParam(), nu, reference(nu));
    EXPECT_NEAR(std::log2(error[1] / error[2]), order, 0.25) << nu;
    EXPECT_LT(error[2], GetParam() == Element::q8 ? 1e-5 : 5e-3) << nu;
  }
}
INSTANTIATE_TEST_SUITE_P(, Refinement, testing::ValuesIn(all_elements),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST(Locking, FullIntegrationLocksAndMeanDilatationDoesNot) {
  const double nu = 0.4999, exact = reference(nu);
  std::map<Element, std::vector<double>> error;
  for (Element element : all_elements) error[element] = errors(element, nu, exact);
  const auto of_mesh_b = [&](Element element) {
    const double value = compliance(mesh_b(element, nu)) / exact;
    std::printf("%-5s on mesh B: %.4f of the compliance of q8 on 320 x 32 cells\n", name(element), value);
    return value;
  };
  EXPECT_LT(of_mesh_b(Element::q4), 0.5);
  EXPECT_NEAR(of_mesh_b(Element::bbar), 1, 0.03);
  EXPECT_NEAR(of_mesh_b(Element::q4i), 1, 0.03);
  EXPECT_NEAR(of_mesh_b(Element::q8), 1, 0.03);
  // Refinement hardly frees q4; bbar converges as if the rubber were compressible.
  EXPECT_GT(error[Element::q4][2], 0.1);
  EXPECT_LT(error[Element::bbar][2], 0.01);
  EXPECT_NEAR(std::log2(error[Element::bbar][1] / error[Element::bbar][2]), 2, 0.3);
}

TEST(Locking, IsAbsentWhereTheRubberIsCompressible) {
  const double exact = reference(0.3);
  for (Element element : all_elements) EXPECT_NEAR(compliance(mesh_b(element, 0.3)) / exact, 1, 0.02) << name(element);
}

}  // namespace tactel::fem::refinement_test
