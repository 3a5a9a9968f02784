// SPDX-License-Identifier: Apache-2.0

// Tactels within the rubber. Expected integrals are of a program of 30 digits, which has the layer's own closed forms
// at a height s = a z, p and q of fem/pad/pad_markers.h:
//
//     sigma_z / (2 G k) = p [2 (1 - nu) cosh s - s sinh s] - q [(1 - 2 nu) sinh s + s cosh s]
//     tau / (2 G k) = p [(1 - 2 nu) sinh s - s cosh s] - q [2 (1 - nu) cosh s + s sinh s],    across: cosh s / cosh a
#include <gtest/gtest.h>

#include <cmath>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem::tactel_depth_test {

PadSensor at(double depth, double poisson) { return {.thickness = 1, .young = 1, .poisson = poisson, .depth = depth}; }

TEST(TactelDepth, StressIsThatOfAnIndependentProgram) {
  const struct {
    double poisson, depth, rho;
    std::array<double, 5> expected;  // b0, bA, bB, bxz, bzx
  } cases[] = {{0.45, 0.5, 0.8, {0.558940657003, 0.795792310993, -0.560111900523, 0.41472492945, 1.019370278}},
               {0.3, 0.25, 1.5, {0.00443068481389, 0.249150076495, -0.181425706196, 0.0858113416858, 0.233079469779}},
               {0.5, 0.75, 0.3, {5.38882837474, 3.99398179232, -3.69449919007, 5.92419167559, 6.27951297428}},
               {0.48, 0.4, 0.0, {9.49514552656, 0.558692910426, 0, 0, 0}}};
  for (const auto& c : cases) {
    const auto found = pad_layer(rubber(at(c.depth, c.poisson))).stresses(c.rho);
    for (int k = 0; k < 5; ++k) EXPECT_NEAR(found[k], c.expected[k], 1e-8 * std::abs(c.expected[0]) + 1e-8) << c.rho;
  }
}

// What the surface bears passes each plane: the integrals of sigma_z by f_z and of tau_x by f_x are 1, also between
// unlike layers, and within one. Simpson's rule, 1 / 400 of the depth apart.
TEST(TactelDepth, ForcesPassEachPlane) {
  PadSensor covered = with_layers(PadSensor{.layers = {{0.8, 0.2, 0.3}, {0.2, 1, 0.48}}});
  for (const auto& [layered, depth] : {std::pair{false, 0.1}, {false, 0.5}, {false, 0.75}, {true, 0.3}, {true, 0.75}}) {
    PadSensor sensor = layered ? covered : at(0, 0.45);
    sensor.depth = depth * sensor.thickness;
    const PadLayer layer = pad_layer(rubber(sensor));
    EXPECT_NEAR(layer.deep(), 1 - depth, 1e-12);
    const double step = (1 - depth) / 400;
    double normal = 0, shear = 0;
    for (int k = 0; k * step < layer.reach(); ++k) {
      const double rho = k * step, weight = step / 3 * (k % 2 ? 4 : 2) * rho;
      normal += weight * layer.stresses(rho)[0], shear += weight * layer.stresses(rho)[1];
    }
    EXPECT_NEAR(normal, 1, 1e-6) << depth;
    EXPECT_NEAR(shear, 1, 1e-4) << depth;  // 1 / rho^3 of shear that is carried far
  }
}

// A height that an interface has is that interface, another splits a layer; the base is no height.
TEST(TactelDepth, LiesBetweenLayers) {
  PadSensor sensor = with_layers(PadSensor{.layers = {{1, 0.2, 0.3}, {0.5, 1, 0.48}, {0.5, 2, 0.48}}});
  const auto levels = [&](double depth) {
    sensor.depth = depth;
    const Rubber all = rubber(sensor);
    return std::pair(all.below, all.layers.size());
  };
  EXPECT_EQ(levels(0), std::pair(0, std::size_t{3}));
  EXPECT_EQ(levels(1), std::pair(1, std::size_t{3}));
  EXPECT_EQ(levels(1.5), std::pair(2, std::size_t{3}));
  EXPECT_EQ(levels(0.3), std::pair(1, std::size_t{4}));
  EXPECT_EQ(levels(1.2), std::pair(2, std::size_t{4}));
  EXPECT_TRUE(rubber(at(0, 0.4)).layers.empty());
}

// The contact is the same; at 1e-4 of the thickness the stress is that of the base, farther up it adds up to the load
// within the 27 mm of the tactels.
TEST(TactelDepth, ScenesHaveTheirLoadAtEveryDepth) {
  PadScene scene;
  scene.sensor = {.tactels = {61, 61}, .pitch = {0.45, 0.45}, .thickness = 2, .young = 1, .poisson = 0.3};
  scene.indenter.shape = Sphere{6}, scene.friction = 0.5;
  scene.load = {.indentation = {0.2}, .drags = {{0.04, 0.02, 0.01}}};
  const PadOptions options{.cells = 8, .tolerance = 1e-7};
  const auto solved = [&](double depth) {
    scene.sensor.depth = depth;
    return PadSolver(pad_layer(scene), options).solve(scene).steps.back();
  };
  const PadStep base = solved(0), low = solved(2e-4);
  EXPECT_LT((low.stress - base.stress).cwiseAbs().maxCoeff(), 1e-3 * base.stress.cwiseAbs().maxCoeff());
  for (const double depth : {0.4, 1.0, 1.5}) {
    const PadStep step = solved(depth);
    EXPECT_NEAR(step.P, base.P, 1e-6 * base.P);
    const Eigen::RowVector3d sums = 0.45 * 0.45 * step.stress.colwise().sum();
    EXPECT_NEAR(sums[0], -step.P, 2e-3 * step.P) << depth;
    EXPECT_NEAR(sums[1], step.Q[0], 5e-3 * step.P) << depth;
    EXPECT_NEAR(sums[2], step.Q[1], 5e-3 * step.P) << depth;
    EXPECT_LT(step.stress.minCoeff(), 1.05 * base.stress.minCoeff());  // nearer to the load
  }
}

TEST(TactelDepth, RefusesWhatIsNone) {
  for (const double depth : {-0.1, 0.76, std::nan("")}) EXPECT_THROW(validate(at(depth, 0.4)), ValueError) << depth;
  PadSensor block = at(0.2, 0.4);
  block.length = block.width = 20;
  EXPECT_THROW(validate(block), ValueError);
  block.sides = Sides::held;
  validate(block);
}

}  // namespace tactel::fem::tactel_depth_test
