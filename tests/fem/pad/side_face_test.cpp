// SPDX-License-Identifier: Apache-2.0

// What tactels show under a flat face wider than a pad of 19 x 19 x 4.5 mm with free sides, whose rubber flees outward
// (docs/pads.md). Expected: an independent program on 16 x 16 cells, but for what is stated otherwise.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem::side_face_test {

PadScene face(double poisson, double friction, double H = 4.5) {
  PadScene scene;
  scene.sensor = {.thickness = H, .young = 0.5, .poisson = poisson, .length = 19, .width = 19};
  scene.indenter.shape = Box{{20, 20}, 0};
  scene.friction = friction;
  scene.load.indentation = {0.1};
  return scene;
}

PadSolution solved(const PadScene& scene) {
  PadSolution solution = PadSolver(pad_layer(scene.sensor.poisson), {.cells = 12, .tolerance = 1e-5}).solve(scene);
  for (const PadStep& step : solution.steps) EXPECT_TRUE(step.converged);
  return solution;
}

double mean_normal(const PadStep& step) { return -step.stress.col(0).mean(); }

/// Shear away from the pad's middle, mean of the tactels over the mean normal stress.
double outward(const PadScene& scene, const PadStep& step) {
  const Eigen::MatrixX2d places = tactel_places(scene.sensor);
  double sum = 0;
  for (Eigen::Index k = 0; k < places.rows(); ++k)
    sum += step.stress.row(k).tail<2>().dot(places.row(k)) / places.row(k).norm();
  return sum / static_cast<double>(places.rows()) / mean_normal(step);
}

struct Press {
  double poisson, friction, H, outward;
};

class Pressed : public testing::TestWithParam<Press> {};

TEST_P(Pressed, ShearsTheTactelsOutward) {
  const auto& [poisson, friction, H, expected] = GetParam();
  const PadScene scene = face(poisson, friction, H);
  EXPECT_NEAR(outward(scene, solved(scene).steps[0]), expected, 0.02) << poisson << " " << friction << " " << H;
}

INSTANTIATE_TEST_SUITE_P(SideFace, Pressed,
                         testing::Values(Press{0.3, 0.5, 4.5, 0.133}, Press{0.4, 0.5, 4.5, 0.223},
                                         Press{0.45, 0.5, 4.5, 0.296}, Press{0.48, 0.5, 4.5, 0.364},
                                         Press{0.4999, 0.5, 4.5, 0.414}, Press{0.48, 0.2, 4.5, 0.40},
                                         Press{0.48, 1, 4.5, 0.35}, Press{0.48, 0.5, 6, 0.41}));

TEST(SideFace, SlipsAsItIsPressed) {
  for (const auto& [friction, stick] : {std::pair{0.3, 0.14}, {0.5, 0.39}, {1.0, 1.0}})
    EXPECT_NEAR(solved(face(0.48, friction)).steps[0].stick_fraction, stick, 0.06) << friction;
}

TEST(SideFace, SlippingLetsRubberOut) {
  // Dragged or twisted until all slides, at one depth.
  PadScene dragged = face(0.48, 0.5), twisted = dragged;
  for (int k = 1; k <= 12; ++k) {
    dragged.load.drags.push_back({0.04375 * k, 0, 0});
    twisted.load.drags.push_back({0, 0, 0.00875 * k});
  }
  const PadSolution drag = solved(dragged), twist = solved(twisted);
  EXPECT_NEAR(drag.steps.back().P / drag.steps[0].P, 1 - 0.29, 0.02);
  EXPECT_NEAR(twist.steps.back().P / twist.steps[0].P, 1 - 0.35, 0.02);
  EXPECT_NEAR(*drag.steps.back().slip_index, 1, 0.01);
  // The change in shear since the press over the mean normal stress then: alike at all tactels up to S = 0.4; at the
  // end the corners have less than the middle. Normal stress falls most in the middle.
  const double normal = mean_normal(drag.steps[0]);
  const auto shear = [&](std::size_t k, Eigen::Index tactel) {
    return (drag.steps[k].stress.row(tactel) - drag.steps[0].stress.row(tactel)).tail<2>().norm() / normal;
  };
  std::size_t early = 1;
  while (*drag.steps[early + 1].slip_index < 0.45) ++early;
  EXPECT_NEAR(shear(early, 0) - shear(early, 5), 0.014, 0.02);
  EXPECT_NEAR(shear(early, 5), 0.21, 0.03);
  EXPECT_LT(shear(12, 0) - shear(12, 5), -0.05);
  const auto normal_left = [&](Eigen::Index tactel) {
    return drag.steps.back().stress(tactel, 0) / drag.steps[0].stress(tactel, 0);
  };
  EXPECT_LT(normal_left(5), 0.6);
  EXPECT_GT(normal_left(0), 0.7);
}

}  // namespace tactel::fem::side_face_test
