// SPDX-License-Identifier: Apache-2.0

// Steps of one contact against the path that PadSolver walks, a cell by hand, and the wrench that was asked.
#include "fem/pad/pad_step.h"

#include <gtest/gtest.h>

#include <limits>

#include "fem/pad/pad_layers.h"

namespace tactel::fem::pad_step_test {

const PadSensor rubber{.thickness = 2, .young = 1.5, .poisson = 0.45};

TEST(SteppedContact, WalksThePath) {
  PadScene scene{.sensor = rubber, .indenter = {.shape = Sphere{.radius = 6}}, .friction = 0.4};
  scene.load.indentation = {0.2};
  scene.load.drags = {{0.05, 0.01, 0.01}, {0.1, 0.03, 0.05}, {0.05, 0.05, 0.0}};
  const PadLayer layer = pad_layer(rubber.poisson);
  PadOptions options;
  options.cells = 8;
  const PadCells cells = fixed_cells(8, 0.4);
  const PadSolution path = PadSolver(layer, options).solve_on(cells, scene);
  SteppedContact steps(layer, rubber, cells, scene.friction, options);
  steps.set_surface(pad_surface(cells, scene.indenter, {0, 0}, 0));
  std::size_t k = 0;
  for (const PadIncrement& increment : pad_increments(scene, options, cells)) {
    const PadTarget& to = increment.target;
    const SteppedState s = steps.move(to.normal, {to.x, to.y, to.twist});
    if (!increment.asked) continue;
    const PadStep& expected = path.steps[k++];
    EXPECT_DOUBLE_EQ(s.force[0], expected.P);
    EXPECT_NEAR(s.force[1], expected.Q[0], 1e-12 * expected.P);
    EXPECT_NEAR(s.force[3], expected.M, 1e-12 * expected.P);
    EXPECT_DOUBLE_EQ(s.stick_fraction, expected.stick_fraction);
    EXPECT_NEAR(s.slip_index, *expected.slip_index, 1e-12);
  }
  EXPECT_EQ(k, path.steps.size());
}

/// One cell, covered by a half: pressed by d it bears d / (2 zz), dragged by x at most x / (2 tt).
TEST(SteppedContact, ACoveredPartGivesWayOnItsOwn) {
  const PadLayer layer = pad_layer(rubber.poisson);
  const PadCells cells = fixed_cells(4, 0.5);
  PadOptions options;
  options.tolerance = 1e-12, options.accept = 1e-9;
  PadSurface surface{Eigen::ArrayXd::Constant(16, std::numeric_limits<double>::infinity()), Eigen::ArrayXd::Ones(16)};
  surface.height[5] = 0, surface.cover[5] = 0.5;
  const CellInfluence own = layer.influence(2, 0.5, 0.5, 0, 0);
  SteppedContact steps(layer, rubber, cells, 10, options);
  steps.set_surface(surface);
  const double unit = rubber.young * cells.area();
  EXPECT_NEAR(steps.move(0.1, {0, 0, 0}).force[0], unit * 0.1 / (2 * own.zz), 1e-9);
  EXPECT_NEAR(steps.move(0.1, {0.02, 0, 0}).force[1], unit * 0.02 / (2 * own.xx), 1e-9);
}

TEST(SteppedContact, MeetsAWrench) {
  const PadLayer layer = pad_layer(rubber.poisson);
  const PadCells cells = fixed_cells(8, 0.4);
  PadOptions options;
  options.tolerance = 1e-7, options.accept = 1e-5;
  SteppedContact steps(layer, rubber, cells, 0.5, options);
  steps.set_surface(pad_surface(cells, {.shape = Sphere{.radius = 6}}, {0.1, 0.2}, 0), {0.1, 0.2});
  const PadWrench first(0.5, 0, 0, 0), then(0.6, 0.15, -0.05, 0.02);
  EXPECT_LE((steps.press(first, 1e-5).force - first).cwiseAbs().maxCoeff(), 1e-5);
  const SteppedState s = steps.press(then, 1e-5);
  EXPECT_TRUE(s.met);
  EXPECT_LE((s.force - then).cwiseAbs().maxCoeff(), 2e-5);
  const double ratio = then.segment<2>(1).norm() / (0.5 * then[0]);
  EXPECT_GT(s.slip_index, ratio);  // the torque takes its part
  EXPECT_LT(s.slip_index, ratio + 0.1);
}

}  // namespace tactel::fem::pad_step_test
