// SPDX-License-Identifier: Apache-2.0

// Objects that give way, too: closed forms of two half-spaces, and values of an independent program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "fem/layer/legendre_points.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_search.h"
#include "fem/pad/pad_solver.h"
#include "tests/fem/pad/named_pad_scenes.h"

namespace tactel::fem::soft_object_test {

constexpr double pi = std::numbers::pi;

/// Boussinesq and Cerruti: point forces on a half-space of E = 1, x, y from the force.
CellInfluence of_point(double nu, double x, double y) {
  const double r = std::hypot(x, y), c = (1 + nu) / pi;
  return {.zz = c * (1 - nu) / r,
          .xx = c * (1 - nu + nu * x * x / (r * r)) / r,
          .yy = c * (1 - nu + nu * y * y / (r * r)) / r,
          .xy = c * nu * x * y / (r * r * r),
          .xz = c * (1 - 2 * nu) / 2 * x / (r * r),
          .yz = c * (1 - 2 * nu) / 2 * y / (r * r)};
}

TEST(SoftObject, InfluenceIsThatOfPointForcesOverTheCell) {
  const double nu = 0.3, softness = 2.5, hx = 0.4, hy = 0.7, x = 1.2, y = -0.7;
  CellInfluence sum;
  for (const LegendrePoint& p : legendre_points(16))
    for (const LegendrePoint& q : legendre_points(16)) {
      const CellInfluence c = of_point(nu, x - hx / 2 * p.x, y - hy / 2 * q.x);
      const double w = softness * p.weight * q.weight / 4 * hx * hy;
      sum += {w * c.zz, w * c.xx, w * c.yy, w * c.xy, -w * c.xz, -w * c.yz};
    }
  const CellInfluence made = SoftObject{softness, nu}.influence(hx, hy, x, y);
  EXPECT_NEAR(made.zz, sum.zz, 1e-12);
  EXPECT_NEAR(made.xx, sum.xx, 1e-12);
  EXPECT_NEAR(made.yy, sum.yy, 1e-12);
  EXPECT_NEAR(made.xy, sum.xy, 1e-12);
  EXPECT_NEAR(made.xz, sum.xz, 1e-12);
  EXPECT_NEAR(made.yz, sum.yz, 1e-12);
}

// Far away any cell is a point force, however wide it is beside the layer, which does not move there.
TEST(SoftObject, MovesFarFromWideCellsAsByAPointForce) {
  const PadLayer layer = pad_layer(0.45).beside({3, 0.2});
  for (const double h : {0.5, 2.0, 30.0}) {
    constexpr int n = 40;
    const std::vector<CellInfluence> all = layer.influences(1, h, h, n);
    const CellInfluence &made = all.back(), point = of_point(0.2, n * h, n * h);
    for (const auto& [of_cell, of_force] : {std::pair{made.zz, point.zz}, {made.xx, point.xx}, {made.xz, -point.xz}})
      EXPECT_NEAR(of_cell, 3 * h * h * of_force, 2e-3 * 3 * h * h * std::abs(of_force)) << h;
  }
}

/// A ball on rubber so thick that it is a half-space.
struct Half {
  double nu = 0.45, R = 1, d = 1e-4, a = std::sqrt(R * d);
  PadScene scene = scene_of(Paraboloid{{R, R}}, d, 1e5 * a, nu, 0.5, {});
  PadCells cells{.n = 24, .hx = 2.06 * a / 24, .hy = 2.06 * a / 24};

  PadStep pressed(double young, double poisson) {
    scene.indenter.young = young, scene.indenter.poisson = poisson;
    return PadSolver(pad_layer(scene), {.cells = 24, .tolerance = 1e-8}).solve_on(cells, scene).steps.back();
  }
};

TEST(SoftObject, TwoBodiesOfHertz) {
  Half half;
  for (const auto& [young, poisson] : {std::pair{1.0, 0.45}, {2.0, 0.3}, {0.2, 0.0}, {30.0, 0.5}}) {
    const double E = 1 / (1 - half.nu * half.nu + (1 - poisson * poisson) / young);
    half.scene.friction = 0;
    EXPECT_NEAR(half.pressed(young, poisson).P / (4.0 / 3 * E * std::sqrt(half.R) * std::pow(half.d, 1.5)), 1, 0.003)
        << young;
  }
}

// Both surfaces move inwards alike (L. E. Goodman, J. Appl. Mech. 29, 1962, 515-522).
TEST(SoftObject, EqualBodiesBearNoShearUnderAPress) {
  Half half;
  const auto shear = [](const PadStep& step) {
    return step.tangential_force.cwiseAbs().maxCoeff() / step.normal_force.maxCoeff();
  };
  EXPECT_LT(shear(half.pressed(1, 0.45)), 1e-6);
  EXPECT_GT(shear(half.pressed(1, 0.2)), 0.01);
}

TEST(SoftObject, AHardOneIsRigid) {
  Half half;
  const PadStep hard = half.pressed(1e6, 0.3);
  half.scene.indenter.young.reset();
  const PadStep rigid =
      PadSolver(pad_layer(half.nu), {.cells = 24, .tolerance = 1e-8}).solve_on(half.cells, half.scene).steps.back();
  EXPECT_NEAR(hard.P / rigid.P, 1, 2e-6);
  EXPECT_NE(hard.P, rigid.P);
}

struct OfProgram {
  double young, P, S, Qx;
};

class SoftBall : public testing::TestWithParam<OfProgram> {};

// The program: 16 x 16 cells in NumPy and C++, Gauss-Seidel, the margin by linear programming.
TEST_P(SoftBall, HasTheTotalsOfAnIndependentProgram) {
  const auto& [young, P, S, Qx] = GetParam();
  PadScene scene =
      scene_of(Paraboloid{{12, 12}}, 0.5, 4, 0.48, 0.6, {{0.05, 0, 0}, {0.1, 0, 0}, {0.15, 0, 0}, {0.2, 0, 0}});
  scene.load.indentation_steps = 6;
  scene.indenter.young = young;
  const PadOptions options{.cells = 16, .tolerance = 1e-8, .pressing_increments = 6, .limit_increments = 0};
  const PadCells cells{.n = 16, .hx = 6.6 / 16, .hy = 6.6 / 16};
  const PadSolution solution = PadSolver(pad_layer(scene), options).solve_on(cells, scene);
  EXPECT_NEAR(solution.steps[5].P, P, 2e-5);
  EXPECT_NEAR(solution.steps.back().Q[0], Qx, 2e-5);
  EXPECT_NEAR(solution.steps.back().slip_index.value(), S, 6e-5);
}

INSTANTIATE_TEST_SUITE_P(Moduli, SoftBall,
                         testing::Values(OfProgram{1e9, 5.398578, .43169, 1.39442},
                                         OfProgram{20, 4.720484, .44743, 1.26419},
                                         OfProgram{5, 3.461304, .48053, .99591}, OfProgram{2, 2.275570, .51880, .70717},
                                         OfProgram{1, 1.454169, .54756, .47710}));

TEST(SoftObject, TheSearchMeetsAForce) {
  PadScene scene = scene_of(Sphere{8}, 0, 2, 0.48, 0.5, {});
  scene.load.indentation.clear(), scene.load.normal_force = {2};
  double last = 0;
  for (const double young : {1e3, 3.0, 0.3, 1e-3}) {
    scene.indenter.young = young;
    const PadSearch found = find_pad_contact(scene, pad_layer(scene));
    EXPECT_NEAR(found.P, 2, 0.04) << young;
    EXPECT_GT(found.depth, last);
    last = found.depth;
    const PadStep step = PadSolver(pad_layer(scene)).solve(scene).steps.back();
    EXPECT_TRUE(step.converged) << young;
    EXPECT_NEAR(step.P, 2, 4e-3) << young;
  }
}

// Mindlin's ratio for two bodies; where both are equal it is that of one.
TEST(SoftObject, SlidesAsFarAsBothGiveWay) {
  PadScene scene = scene_of(Sphere{8}, 0.2, 1e6, 0.3, 0.5, {});
  const PadCells cells{.n = 12, .hx = 0.1, .hy = 0.1};
  const double rigid = sliding_limit(scene, 0.2, cells);
  scene.indenter.young = 1, scene.indenter.poisson = 0.3;
  EXPECT_DOUBLE_EQ(sliding_limit(scene, 0.2, cells), rigid);
  scene.indenter.poisson = 0.5;
  EXPECT_NEAR(sliding_limit(scene, 0.2, cells), 0.5 * 0.2 * (1.7 * 1.3 + 1.5 * 1.5) / (2 * (0.91 + 0.75)), 1e-12);
  scene.load.normal_force = {1};
  const double soft = sliding_limit(scene, 1, cells), a = std::sqrt(1.44 / pi);
  scene.indenter.young.reset();
  EXPECT_NEAR(soft - sliding_limit(scene, 1, cells), 1.5 * 0.5 * 1.5 * 1.5 / (4 * a), 1e-12);
}

TEST(SoftObject, ASolverRefusesTheLayerOfAnother) {
  PadScene scene = scene_of(Sphere{8}, 0.2, 2, 0.48, 0.5, {});
  scene.indenter.young = 1;
  const PadLayer layer = pad_layer(0.48);
  EXPECT_THROW(PadSolver(layer).solve(scene), std::logic_error);
}

}  // namespace tactel::fem::soft_object_test
