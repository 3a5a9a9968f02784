// SPDX-License-Identifier: Apache-2.0

// Wide contacts on thin, incompressible rubber: Reynolds' equation, and many elements with constant pressures.
#include "fem/layer/linear_elements.h"

#include <gtest/gtest.h>

#include "fem/layer/patch_exact.h"
#include "layer_sensors.h"

namespace tactel::fem::linear_elements_test {

/// A parabola pressed `depth` deep, without friction, that touches `half_width` to a side by Reynolds' equation.
Scene pressed_parabola(double half_width, double depth) {
  return {.sensor = {.length = 150, .thickness = 1, .young = 1, .poisson = 0.5, .tactel_span = 100},
          .indenter = {.shape = Parabola{half_width * half_width / (6 * depth)}},
          .friction = 0,
          .load = {.indentation = {depth}},
          .model = SurfaceModel::patch};
}

/// Reynolds: u_y = -(h^3 / E) p'' on incompressible rubber whose surface slides freely. Below a parabola p = p' = 0 at
/// the ends, a^2 = 6 R depth, and P = (4/15) E depth a^3 / h^3. The rubber beyond the ends gives way as well, over a
/// length of some h: P of the equation is low by a few h / a.
TEST(LinearElements, ReynoldsEquation) {
  const Scene scene = pressed_parabola(40, 0.05);
  const LayerModel model = endless_layer(scene.sensor);
  const double P = 4.0 / 15 * 0.05 * 40 * 40 * 40;
  for (const int elements : {16, 24, 48}) {
    const ContactSolution found = PatchReference(model, {.elements = elements, .pressing_increments = 1}).solve(scene);
    EXPECT_TRUE(found.linear_elements);
    EXPECT_NEAR(found.steps[0].P, P, 0.06 * P) << elements;
  }
  // constant pressures have no curvature
  const Patch patch{-45, 45, 24};
  EXPECT_LT(solve_patch_exactly(model, patch, scene, 1).steps[0].P, 0.9 * P);
}

/// 240 elements of 0.3 h with constant pressures hardly feel that they are constant.
TEST(LinearElements, AgreeWithManyConstantOnes) {
  Scene scene = pressed_parabola(25, 0.05);
  scene.friction = 0.3;
  scene.load.tangential = {0.2, 0.8};
  const LayerModel model = endless_layer(scene.sensor);
  const ContactSolution many = solve_patch_exactly(model, {-33, 33, 220}, scene, 8);
  const ContactSolution few = PatchReference(model, {.elements = 32, .pressing_increments = 8}).solve(scene);
  ASSERT_TRUE(few.linear_elements);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(few.steps[k].P, many.steps[k].P, 0.02 * many.steps[0].P) << k;
    EXPECT_NEAR(*few.steps[k].slip_index, *many.steps[k].slip_index, 0.01) << k;
    // at the tactels: 5 mm apart, over forces that are spread and not points
    EXPECT_LT((few.steps[k].sigma_y - many.steps[k].sigma_y).cwiseAbs().maxCoeff(),
              0.05 * many.steps[0].sigma_y.cwiseAbs().maxCoeff());
  }
}

/// Uniform pressure is in both kinds: with one displacement on all of a wide patch the middle is the oedometer's.
TEST(LinearElements, TheOedometer) {
  Scene scene = pressed_parabola(1, 0.1);
  scene.sensor.poisson = 0.495;
  scene.indenter.shape = Flat{40};
  const LayerModel model = endless_layer(scene.sensor);
  const ContactSolution found = PatchReference(model, {.elements = 40, .pressing_increments = 1}).solve(scene);
  ASSERT_TRUE(found.linear_elements);
  const double stiffness = (1 - 0.495) / ((1 + 0.495) * (1 - 2 * 0.495));  // of 1 mm of rubber, E = 1
  const double p = found.steps[0].normal_force[20] / found.surface_width[20];
  EXPECT_NEAR(p, 0.1 * stiffness, 0.005 * p);
}

TEST(LinearElements, AreOfThinAndHardlyCompressibleRubberOnly) {
  Sensor sensor{.poisson = 0.4999};
  EXPECT_TRUE(needs_linear_pressure(sensor, sensor.thickness));
  EXPECT_FALSE(needs_linear_pressure(sensor, sensor.thickness / 2));
  sensor.poisson = 0.49;
  EXPECT_FALSE(needs_linear_pressure(sensor, 10 * sensor.thickness));
}

}  // namespace tactel::fem::linear_elements_test
