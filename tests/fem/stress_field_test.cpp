// SPDX-License-Identifier: Apache-2.0

// The field inside the block.
#include "fem/gap/stress_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/gap/gap_reference.h"

namespace tactel::fem::stress_field_test {

Scene small_scene(Element element) {
  return {.sensor = {.columns = 21, .rows = 5, .element = element},
          .indenter = {.shape = Parabola{.radius = 10.0}},
          .load = {.indentation = {0.15}}};
}

TEST(StressMeasures, VonMisesByHand) {
  EXPECT_DOUBLE_EQ(von_mises({3.0, 0.0, 0.0, 0.0}), 3.0);             // one-axial: the stress itself
  EXPECT_DOUBLE_EQ(von_mises({-2.0, -2.0, 0.0, -2.0}), 0.0);          // pressure alone
  EXPECT_DOUBLE_EQ(von_mises({0.0, 0.0, 1.0, 0.0}), std::sqrt(3.0));  // pure shear
}

TEST(StressMeasures, PrincipalStrainByHand) {
  EXPECT_DOUBLE_EQ(largest_principal_strain({0.2, 0.0, 0.0, 0.0}, 2.0, 0.3), 0.1);   // sigma / E along x
  EXPECT_DOUBLE_EQ(largest_principal_strain({0.0, -0.4, 0.0, 0.0}, 2.0, 0.3), 0.2);  // compression counts by size
  EXPECT_DOUBLE_EQ(largest_principal_strain({0.0, 0.0, 0.1, 0.0}, 2.0, 0.25),
                   0.0625);  // shear: gamma / 2 = (1 + nu) tau / E
}

class FieldOf : public testing::TestWithParam<Element> {};

TEST_P(FieldOf, TouchingNodesLieOnTheIndenter) {
  const Scene scene = small_scene(GetParam());
  const ContactSolution solution = solve_gap_reference(scene);
  const ContactStep& step = solution.steps.back();
  const StressField field = stress_field(scene.sensor, step);
  int touching = 0;
  for (std::size_t i = 0; i < step.status.size(); ++i) {
    if (step.status[i] == GapStatus::open) continue;
    ++touching;
    const double x = solution.surface_x[static_cast<Eigen::Index>(i)];
    // the closed gap: u_y = profile - depth; fp64 forces of a block with condition below 1e6
    EXPECT_NEAR(field.displacement(1, field.mesh.surface[i]), x * x / 20.0 - 0.15, 1e-10);
  }
  EXPECT_GE(touching, 3);
  for (const int node : field.mesh.base) EXPECT_EQ(field.displacement.col(node).norm(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Elements, FieldOf, testing::Values(Element::bbar, Element::q4i, Element::q8),
                         [](const auto& info) { return name(info.param); });

TEST(StressField, UniformPressureOnAWideBlock) {
  // A flat indenter wider than a long block without friction, nu = 0: every column is compressed by itself, sigma_y =
  // -E depth / thickness.
  Scene scene = small_scene(Element::q4);
  scene.sensor.poisson = 0.0;
  scene.indenter.shape = Flat{};
  scene.friction = 0.0;
  scene.load.indentation = {0.03};
  const StressField field = stress_field(scene.sensor, solve_gap_reference(scene).steps.back());
  const double stress = -2.0 * 0.03 / 1.5;
  EXPECT_LT((field.stress.row(1).array() - stress).abs().maxCoeff(), 1e-12);  // exact but for rounding
  EXPECT_LT(field.stress.row(0).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((field.strain.array() - 0.02).abs().maxCoeff(), 1e-12);
}

}  // namespace tactel::fem::stress_field_test
