// SPDX-License-Identifier: Apache-2.0

// Contacts on pads with free sides: how cells end at the pad's edge, symmetries, and beside a finer judge.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/pad_search.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem::side_cells_test {

constexpr double L = 19;

/// A press and drags up to near sliding on a square pad, E = 1 MPa, mu = 0.5.
PadScene on_square(const PadShape& shape, std::array<double, 2> position, double yaw, double depth, double H,
                   double nu) {
  PadScene scene;
  scene.sensor = {.thickness = H, .young = 1, .poisson = nu, .length = L, .width = L};
  scene.indenter = {.shape = shape, .position = position, .yaw = yaw};
  scene.load.indentation = {depth};
  const double way = scene.friction * depth;
  for (const double k : {0.5, 1.0, 1.5}) scene.load.drags.push_back({k * way, 0.2 * k * way, k * k * way / 10});
  return scene;
}

PadSolution solved(const PadScene& scene, int cells = 12, SideBricks bricks = SideBricks::usual) {
  PadSolution solution = PadSolver(pad_layer(scene.sensor.poisson),
                                   {.cells = cells, .tolerance = 1e-5, .pressing_increments = 4, .side_bricks = bricks})
                             .solve(scene);
  for (const PadStep& step : solution.steps) EXPECT_TRUE(step.converged);
  return solution;
}

TEST(SideCells, EndAtThePadsEdge) {
  // A face over all of the pad covers it exactly; a box's own edge within the pad is overhung by 0.09 of a cell.
  const PadBox all = solved(on_square(Box{{20, 20}, 0}, {1, 0}, 90, 0.1, 4.5, 0.48)).cells.box();
  EXPECT_NEAR(all.x.left, -L / 2, 1e-9);  // the frame is turned by 90 degrees: its x lies along y of the pad
  EXPECT_NEAR(all.y.right, L / 2 + 1, 1e-9);
  EXPECT_NEAR(all.y.left, -L / 2 + 1, 1e-9);
  const PadCells part = solved(on_square(Box{{10, 20}, 0}, {8, 0}, 0, 0.1, 4.5, 0.48)).cells;
  EXPECT_NEAR(part.box().x.left, -10 - 0.09 * part.hx, 1e-9);
  EXPECT_NEAR(part.box().x.right, L / 2 - 8, 1e-9);
  EXPECT_EQ(part.edge, (std::array{true, true, true, true}));
  // An edge nearer to the pad's than that: the cells end at the pad's.
  const PadBox near = solved(on_square(Box{{9.45, 20}, 0}, {0, 0}, 0, 0.1, 4.5, 0.48)).cells.box();
  EXPECT_NEAR(near.x.right, L / 2, 1e-9);
}

TEST(SideCells, ShareWhatAnObliqueEdgeCovers) {
  const PadScene scene = on_square(Box{{10, 20}, 0}, {9, 0}, 30, 0.1, 4.5, 0.48);
  const PadSolution solution = solved(scene);
  EXPECT_TRUE(solution.cells.shared);
  EXPECT_NEAR(solution.cells.frame(scene.indenter), 0, 1e-12);
  const Eigen::MatrixXd shares = covered_shares(solution.cells, scene.indenter);
  double covered = 0;  // of the pad: what lies beyond the line x cos 30 + y sin 30 = 9 cos 30 - 10
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) covered += shares(i + 1, j + 1) * solution.cells.area();
  double exact = 0;
  constexpr int strips = 2000;
  for (int k = 0; k < strips; ++k) {
    const double y = L * ((k + 0.5) / strips - 0.5);
    const double x = 9 - 10 / std::cos(std::numbers::pi / 6) - y * std::tan(std::numbers::pi / 6);
    exact += L / strips * std::clamp(L / 2 - x, 0.0, L);
  }
  EXPECT_NEAR(covered, exact, 0.005 * exact);  // 16 x 16 points a cell
}

TEST(SideCells, QuarterTurnsAndMirrorsTurnTheAnswer) {
  const PadStep a = solved(on_square(Box{{4, 2}, 0}, {7, 3}, 0, 0.1, 4.5, 0.48)).steps.front(),
                b = solved(on_square(Box{{2, 4}, 0}, {7, 3}, 90, 0.1, 4.5, 0.48)).steps.front(),
                c = solved(on_square(Box{{2, 4}, 0}, {-3, 7}, 0, 0.1, 4.5, 0.48)).steps.front();
  EXPECT_NEAR(b.P, a.P, 1e-4 * a.P);  // the tolerance of the sweeps
  EXPECT_NEAR(c.P, a.P, 1e-4 * a.P);
  EXPECT_LT((b.Q - a.Q).norm(), 1e-4 * a.P);
  EXPECT_LT((c.Q - Eigen::Vector2d(-a.Q[1], a.Q[0])).norm(), 1e-4 * a.P);
  EXPECT_LT((a.stress - b.stress).cwiseAbs().maxCoeff(), 1e-3 * a.stress.cwiseAbs().maxCoeff());
}

TEST(SideCells, BaseBearsTheForcesOfTheSurface) {
  // The base stress of a fine array sums to P and Q, but for 2 % that bricks miss at the rim, where it is singular.
  PadScene scene = on_square(Sphere{15}, {6.5, 1}, 0, 0.6, 4.5, 0.48);
  scene.sensor.tactels = {48, 48}, scene.sensor.pitch = {L / 48, L / 48};
  const PadSolution solution = solved(scene);
  for (const PadStep& step : solution.steps) {
    const Eigen::RowVector3d sum = L / 48 * (L / 48) * step.stress.colwise().sum();
    EXPECT_NEAR(sum[0], -step.P, 0.025 * step.P);
    EXPECT_NEAR(sum[1], step.Q[0], 0.025 * step.P);
    EXPECT_NEAR(sum[2], step.Q[1], 0.025 * step.P);
  }
}

TEST(SideCells, MiddleOfAWidePadIsTheEndlessLayer) {
  PadScene scene = on_square(Sphere{8}, {0.3, 0.1}, 0, 0.2, 1.9, 0.48);
  const PadSolution free = solved(scene);
  scene.sensor.sides = Sides::held;
  const PadSolution held = solved(scene);
  // Sides 4 H away. Means and values at the middles of 12 cells differ by half a percent, steep stresses by more;
  // bricks below the base, up to 0.55 H high, leave as much between the ball and the sides.
  const AnswerError off = pad_difference(free, held);
  EXPECT_LT(off.P, 0.01);
  EXPECT_LT(off.S, 0.006);
  EXPECT_LT(off.sigma, 0.025);
}

TEST(SideCells, LongPadsSeeTheirNearerSide) {
  // 12 H of a pad 20 H long; of one 12 H long that lies as far from its side, all.
  PadScene scene = on_square(Sphere{8}, {17, 0.1}, 0, 0.2, 2, 0.48);
  scene.sensor.length = 40;
  const PadStep near_side = solved(scene).steps.back();
  scene.sensor.length = 24, scene.indenter.position[0] = 9;
  const PadStep all = solved(scene).steps.back();
  EXPECT_NEAR(near_side.P, all.P, 1e-9 * all.P);
  EXPECT_NEAR(near_side.slip_index.value(), all.slip_index.value(), 1e-9);
}

/// A scene and what 12 x 12 cells may be off by.
struct Judged {
  const char* name;
  PadShape shape;
  std::array<double, 2> position;
  double yaw, depth;  ///< depth at H = 4.5 mm, in proportion at others
};

std::vector<Judged> judged() {
  return {{"ball in the middle", Sphere{15}, {0.1, 0.2}, 0, 0.6},
          {"ball near the edge", Sphere{15}, {5.1, 0.2}, 0, 0.6},
          {"ball over the edge", Sphere{15}, {8.5, 0.2}, 0, 0.6},
          {"ball at the corner", Sphere{15}, {8, 8}, 0, 0.6},
          {"small ball near the edge", Sphere{6}, {6, 0.2}, 0, 0.5},
          {"face over all", Box{{20, 20}, 0}, {0, 0}, 0, 0.1},
          {"face over all, turned", Box{{20, 20}, 0}, {0, 0}, 30, 0.1},
          {"box edge across", Box{{10, 20}, 0}, {8.22, 0}, 0, 0.1},
          {"box corner", Box{{10, 10}, 0}, {8.2, 7}, 0, 0.1},
          {"box within", Box{{4, 3}, 0}, {1, 1}, 30, 0.1},
          {"oblique box edge, 29 degrees", Box{{10, 20}, 0}, {8, 0}, 28.65, 0.1},
          {"oblique box edge, 45 degrees", Box{{10, 20}, 0}, {9, 2}, 45, 0.1},
          {"rounded box over the edge", Box{{5, 5}, 1}, {7, 0}, 0, 0.2},
          {"punch over the edge", Punch{4, 0}, {7, 0}, 0, 0.1},
          {"punch within", Punch{4, 0}, {1, 0}, 0, 0.1}};
}

/// Beside 24 x 24 cells, `bricks` of which hold the sides.
AnswerError beside_the_judge(const Judged& of, double H, double nu, SideBricks bricks) {
  const PadScene scene = on_square(of.shape, of.position, of.yaw, of.depth * H / 4.5, H, nu);
  return pad_difference(solved(scene), solved(scene, 24, bricks));
}

TEST(SideCells, TwelveAreWithinOnePercentOfAFinerJudge) {
  const std::vector<Judged> all = judged();
  for (const int k : {2, 5, 8, 10, 13}) {
    const Judged& of = all[k];
    const AnswerError off = beside_the_judge(of, 4.5, 0.48, SideBricks::finer);
    EXPECT_LT(off.P, 0.01) << of.name;
    EXPECT_LT(off.S, 0.006) << of.name;
    EXPECT_LT(off.sigma, 0.03) << of.name;
    EXPECT_LT(off.tau, 0.05) << of.name;
  }
}

TEST(SideCellsNightly, TwelveAreNearAFinerJudgeOnAnyRubber) {
  struct Rubber {
    double H, poisson, P;
  };
  // A wide face on thin rubber near nu = 1/2 bears most beside its edge, where stress is steep.
  constexpr double most_S = 0.009;
  for (const Rubber& rubber : {Rubber{4.5, 0.48, 0.0125},
                               {4.5, 0.3, 0.0125},
                               {2, 0.45, 0.015},
                               {6, 0.4999, 0.0125},
                               {3, 0.4999, 0.015},
                               {2, 0.4999, 0.035}})
    for (const Judged& of : judged()) {
      const AnswerError off = beside_the_judge(of, rubber.H, rubber.poisson, SideBricks::finest);
      std::printf("H %g nu %g %-30s P %.2f %% S %.4f sigma %.1f %% tau %.1f %%\n", rubber.H, rubber.poisson, of.name,
                  100 * off.P, off.S, 100 * off.sigma, 100 * off.tau);
      EXPECT_LT(off.P, rubber.P) << of.name << " H " << rubber.H << " nu " << rubber.poisson;
      EXPECT_LT(off.S, most_S) << of.name << " H " << rubber.H << " nu " << rubber.poisson;
    }
}

}  // namespace tactel::fem::side_cells_test
