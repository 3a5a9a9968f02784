// SPDX-License-Identifier: Apache-2.0

// Friction that differs over a pad: what a map says, an independent program's wet spot, and the laws of each cell.
#include <gtest/gtest.h>

#include <cmath>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/pad_step.h"
#include "tests/fem/expect_error.h"

namespace tactel::fem::friction_map_test {

constexpr double side = 6.6 / 16;
const PadCells grid{.n = 16, .hx = side, .hy = side};
const PadOptions exact{
    .cells = 16, .tolerance = 1e-10, .accept = 1e-7, .pressing_increments = 6, .limit_increments = 0};

/// Six presses and twelve drags of a bowl, E = 1.
PadScene bowl() {
  PadScene scene;
  scene.sensor = {.tactels = {2, 2}, .pitch = {1, 1}, .thickness = 4, .young = 1, .poisson = 0.48};
  scene.indenter.shape = Paraboloid{{12, 12}};
  scene.friction = 0.6;
  scene.load.indentation = {0.5}, scene.load.indentation_steps = 6;
  for (int k = 1; k <= 12; ++k) scene.load.drags.push_back({0.06 * k, 0, 0});
  return scene;
}
/// Nodes on the middles of cells: 0.15 from x = 0.6 mm on.
PadScene wet_bowl() {
  PadScene scene = bowl();
  scene.set_friction({{{0.6, 0.6, 0.6, 0.15}}, side});
  return scene;
}
PadSolution solved(const PadScene& scene) { return PadSolver(pad_layer(0.48), exact).solve_on(grid, scene); }

TEST(FrictionMap, IsBilinearBetweenNodesAndConstantBeyond) {
  PadScene scene;
  scene.set_friction({{{0.1, 0.2, 0.4}, {0.5, 0.6, 1.0}}, 2});  // nodes at x -2, 0, 2 and y -1, 1
  EXPECT_EQ(scene.friction, 1.0);
  EXPECT_EQ(friction_text(scene), "1 at most");
  const auto at = [&](double x, double y) { return friction_at(scene, Eigen::RowVector2d(x, y))[0]; };
  EXPECT_DOUBLE_EQ(at(-2, -1), 0.1);
  EXPECT_DOUBLE_EQ(at(2, 1), 1.0);
  EXPECT_DOUBLE_EQ(at(0.5, -1), 0.25);
  EXPECT_DOUBLE_EQ(at(-1, 0.5), (0.15 + 3 * 0.55) / 4);
  EXPECT_DOUBLE_EQ(at(-9, 0), 0.3);
  EXPECT_DOUBLE_EQ(at(9, -9), 0.4);
  scene.set_friction({{{0.3}}, 1});
  EXPECT_EQ(at(5, -2), 0.3);
  EXPECT_EQ(friction_text(scene), "0.3 at most");
}

// A map is fixed to the pad, cells to the indenter.
TEST(FrictionMap, LiesOnThePad) {
  PadScene scene;
  scene.set_friction({{{0, 1}}, 100});  // mu = 1/2 + x / 100
  scene.indenter.position = {10, 3}, scene.indenter.yaw = 90;
  const Eigen::VectorXd mu = friction_on_cells({.n = 2, .hx = 4, .hy = 6}, scene);
  // Cells at own (-2, -3), (-2, 3), (2, -3), (2, 3): their x on the pad is 10 less their own y.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(mu[i], i % 2 == 0 ? 0.63 : 0.57, 1e-12) << i;
}

// P, Qx and S of drags 3, 5, 8 and 12 by an independent program on these cells, without and with the wet spot.
TEST(FrictionMap, AWetSpotIsThatOfAnIndependentProgram) {
  struct Known {
    std::size_t drag;
    double P, Q, S, ratio;
  };
  const auto expect = [](const PadScene& scene, const std::vector<Known>& all) {
    const PadSolution found = solved(scene);
    for (const auto& [drag, P, Q, S, ratio] : all) {
      const PadStep& step = found.steps[5 + drag];
      EXPECT_NEAR(step.P, P, 1e-7) << drag;
      EXPECT_NEAR(step.Q[0], Q, 1e-7) << drag;
      EXPECT_NEAR(*step.slip_index, S, 2e-6) << drag;
      EXPECT_NEAR(step.Q[0] / step.P, ratio, 1e-5) << drag;
    }
  };
  expect(bowl(), {{3, 5.386156030, 1.270917961, 0.393267, 0.23596},
                  {5, 5.368768484, 1.960522163, 0.608619, 0.36517},
                  {8, 5.337516749, 2.736095417, 0.854360, 0.51262},
                  {12, 5.306830564, 3.178306513, 0.998181, 0.59891}});
  expect(wet_bowl(), {{3, 5.398367515, 1.174079479, 0.524259, 0.21749},
                      {5, 5.412577291, 1.695515576, 0.759551, 0.31325},
                      {8, 5.421428229, 2.166877373, 0.974835, 0.39969},
                      {12, 5.412638771, 2.216618471, 0.999428, 0.40953}});
}

// The mean mu is that of all friction, to which the force ratio refers.
TEST(FrictionMap, EachCellSlidesAtItsOwn) {
  PadScene scene = bowl();
  scene.set_friction({{{0.6, 0.3, 0.0, 0.0, 0.2}}, 1.2});
  const PadSolution found = solved(scene);
  const Eigen::VectorXd mu = friction_on_cells(grid, scene);
  const PadStep& step = found.steps.back();
  double bears = 0;
  int slippery = 0;
  for (int i = 0; i < grid.count(); ++i) {
    const double n = step.normal_force[i], t = step.tangential_force.row(i).norm();
    EXPECT_NEAR(t, mu[i] * n, 1e-12) << i;  // all slide
    EXPECT_TRUE(mu[i] > 0 || t == 0) << i;
    slippery += mu[i] == 0 && n > 0;
    bears += mu[i] * n;
    EXPECT_NE(step.status[i], GapStatus::stick) << i;
  }
  EXPECT_GT(slippery, 20);
  EXPECT_NEAR(step.mu, bears / step.P, 1e-12);
  EXPECT_NEAR(*step.force_ratio, step.Q.norm() / bears, 1e-12);
  EXPECT_GT(*step.slip_index, 0.99);
}

// One mu everywhere, in whatever words.
TEST(FrictionMap, OneMuHasTheBitsOfANumber) {
  PadScene scene = bowl();
  const PadSolution one = solved(scene);
  scene.set_friction({{{0.6, 0.6}, {0.6, 0.6}}, 0.7});
  const PadSolution map = solved(scene);
  for (std::size_t k = 0; k < one.steps.size(); ++k) {
    EXPECT_EQ(map.steps[k].normal_force, one.steps[k].normal_force) << k;
    EXPECT_EQ(map.steps[k].tangential_force, one.steps[k].tangential_force) << k;
    EXPECT_EQ(map.steps[k].stress, one.steps[k].stress) << k;
    EXPECT_EQ(map.steps[k].slip_index, one.steps[k].slip_index) << k;
    EXPECT_NEAR(*map.steps[k].force_ratio, *one.steps[k].force_ratio, 1e-14) << k;  // its mu is a mean
  }
}

TEST(FrictionMap, NothingBearsWhereAllIsSlippery) {
  PadScene scene = bowl();
  scene.set_friction({{{0.0, 0.0, 0.0, 0.9}}, 10});  // beyond the contact
  const PadStep step = solved(scene).steps.back();
  EXPECT_GT(step.P, 5);
  EXPECT_FALSE(step.slip_index || step.force_ratio);  // as with mu = 0
  EXPECT_EQ(step.Q, Eigen::Vector2d(0, 0));
}

// A drag is split by the friction of its own cells, not by that elsewhere.
TEST(FrictionMap, DragsAreSplitByTheFrictionAtHand) {
  PadScene scene = bowl(), far = scene;
  scene.friction = 0.1;
  far.set_friction({{{2.0, 0.1, 0.1, 0.1, 2.0}}, 8});
  EXPECT_NEAR(sliding_limit(far, 0.5, grid), sliding_limit(scene, 0.5, grid), 1e-12);
}

// Steps on these cells walk the same way.
TEST(FrictionMap, StepsAreThePath) {
  const PadScene scene = wet_bowl();
  const PadCells cells = fixed_cells(16, side);
  SteppedContact steps(pad_layer(0.48), scene.sensor, cells, 0.3, exact);
  steps.set_friction(friction_on_cells(cells, scene));
  steps.set_surface(pad_surface(cells, scene.indenter, {0, 0}, 0));
  const PadSolution path = solved(scene);
  std::vector<PadTarget> targets = pad_targets(scene.load);
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const SteppedState s = steps.move(targets[k].normal, {targets[k].x, 0, 0});
    EXPECT_NEAR(s.force[0], path.steps[k].P, 1e-8) << k;
    EXPECT_NEAR(s.force[1], path.steps[k].Q[0], 1e-8) << k;
    EXPECT_NEAR(s.slip_index, *path.steps[k].slip_index, 1e-8) << k;
  }
}

TEST(FrictionMap, SaysWhatIsWrong) {
  const auto refused = [](FrictionMap map, const char* key, const char* value, const char* allowed) {
    PadScene scene = bowl();
    scene.set_friction(std::move(map));
    expect_value_error([&] { scene.validate(); }, key, value, allowed);
  };
  const char* key = "contact.friction_map";
  const std::vector<double> long_row(65, 0.5);
  refused({}, key, "0", "1 to 64 rows");
  refused({{{}}}, key, "0", "1 to 64");
  refused({{{0.5, 0.5}, {0.5}}}, key, "1", "as many numbers");
  refused({{long_row}}, key, "65", "1 to 64");
  refused({std::vector<std::vector<double>>(65, {0.5})}, key, "65", "1 to 64");
  refused({{{0.5, -0.1}}}, key, "-0.1", "0 to 100");
  refused({{{0.5, 101}}}, key, "101", "0 to 100");
  refused({{{NAN}}}, key, "nan", "0 to 100");
  refused({{{INFINITY}}}, key, "inf", "0 to 100");
  refused({{{0.5}}, 0}, "contact.friction_pitch", "0", "a length in mm");
  refused({{{0.5}}, NAN}, "contact.friction_pitch", "nan", "a length in mm");
  PadScene scene = bowl();
  scene.set_friction({{{0.5, 0.2}}});
  scene.validate();
}

}  // namespace tactel::fem::friction_map_test
