// SPDX-License-Identifier: Apache-2.0

// Contacts on a pad: six scenes with totals of an independent program, closed forms, and symmetries.
#include "fem/pad/pad_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_presses.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/pad_search.h"
#include "tests/fem/pad/named_pad_scenes.h"

namespace tactel::fem::pad_solver_test {

constexpr double pi = std::numbers::pi;

class NamedPadScene : public testing::TestWithParam<NamedScene> {};

TEST_P(NamedPadScene, HasTheTotalsOfAnIndependentProgram) {
  const NamedScene& named = GetParam();
  const PadLayer layer(named.scene.sensor.poisson);
  const PadSolver solver(layer, {.cells = 16, .tolerance = 1e-8, .pressing_increments = 2, .limit_increments = 0});
  const PadSolution solution = solver.solve_on(named.cells(), named.scene);
  ASSERT_EQ(solution.steps.size(), named.steps.size());
  for (std::size_t k = 0; k < named.steps.size(); ++k) {
    const auto& [P, Qx, Qy, M, S, stick, touch] = named.steps[k];
    if (P == 0) continue;  // not stated
    const PadStep& step = solution.steps[k];
    EXPECT_NEAR(step.P, P, 2e-5) << k;
    EXPECT_NEAR(step.Q[0], Qx, 2e-5) << k;
    EXPECT_NEAR(step.Q[1], Qy, 2e-5) << k;
    EXPECT_NEAR(step.M, M, 2e-5) << k;
    EXPECT_NEAR(step.slip_index.value(), S, 6e-5) << k;  // four digits are stated
    EXPECT_EQ(std::count(step.status.begin(), step.status.end(), GapStatus::stick), stick) << k;
    EXPECT_EQ(step.status.size() - std::count(step.status.begin(), step.status.end(), GapStatus::open), touch) << k;
  }
  for (std::size_t k = 0; k < named.stress.size(); ++k)
    EXPECT_NEAR(solution.steps.back().stress(k < 3 ? 4 : 8, k % 3), named.stress[k], 1e-5) << k;
}

INSTANTIATE_TEST_SUITE_P(Six, NamedPadScene, testing::ValuesIn(named_scenes()),
                         [](const auto& info) { return std::string(info.param.name); });

/// Cells over a disc of radius a and 4 % more.
PadCells over_disc(int n, double a) { return {.n = n, .hx = 2.08 * a / n, .hy = 2.08 * a / n}; }

TEST(PadClosedForms, Hertz) {
  const double nu = 0.3, R = 1, d = 1e-4, a = std::sqrt(R * d), H = 1000 * a;
  const PadScene scene = scene_of(Paraboloid{{R, R}}, d, H, nu, 0, {});
  const PadLayer layer(nu);
  const double E = 1 / (1 - nu * nu), P = 4.0 / 3 * E * std::sqrt(R) * std::pow(d, 1.5), p0 = 2 * E * a / (pi * R);
  for (const auto& [n, off] : {std::pair{12, 0.005}, {24, 0.002}}) {
    const PadCells cells = over_disc(n, a);
    const PadStep step = PadSolver(layer, {.cells = n, .tolerance = 1e-7}).solve_on(cells, scene).steps.back();
    EXPECT_NEAR(step.P / P, 1, off) << n;
    EXPECT_NEAR(step.normal_force.maxCoeff() / cells.area() / p0, 1, n == 12 ? 0.01 : 0.005) << n;
  }
}

TEST(PadClosedForms, DimitriadisOnAThinLayer) {
  // E. K. Dimitriadis et al., Biophys. J. 82 (2002) 2798, for nu = 1/2 bonded: a series in chi = sqrt(R d) / H.
  const double nu = 0.5, R = 1, d = 1e-4, a = std::sqrt(R * d), H = 12 * a, chi = a / H;
  const PadLayer layer(nu);
  const PadScene scene = scene_of(Paraboloid{{R, R}}, d, H, nu, 0, {});
  const double hertz = 16.0 / 9 * std::sqrt(R) * std::pow(d, 1.5);
  const double series = 1 + 1.133 * chi + 1.283 * chi * chi + 0.769 * std::pow(chi, 3) + 0.0975 * std::pow(chi, 4);
  EXPECT_NEAR(series, 1.1038, 1e-4);
  const PadStep step =
      PadSolver(layer, {.cells = 24, .tolerance = 1e-7}).solve_on(over_disc(24, a), scene).steps.back();
  EXPECT_NEAR(step.P / hertz, series, 0.003);
}

/// A sphere on a half-space with nu = 1/2, where pressing and dragging do not couple.
struct Incompressible {
  double nu = 0.5, R = 1, d = 1e-4, a = std::sqrt(R * d), mu = 0.3;
  PadLayer layer{nu};
  PadStep after(const std::array<double, 3>& drag, int n) const { return path({drag}, n, mu).back(); }
  std::vector<PadStep> path(const std::vector<std::array<double, 3>>& drags, int n, double friction) const {
    PadScene scene = scene_of(Paraboloid{{R, R}}, d, 1000 * a, nu, friction, drags);
    scene.load.indentation_steps = 1;
    return PadSolver(layer, {.cells = n, .tolerance = 1e-6, .pressing_increments = 1})
        .solve_on(over_disc(n, a), scene)
        .steps;
  }
};

// Where all slides, tractions stay as they are, and so does the rubber; while a cell sticks, it does not slide as a
// whole.
TEST(PadClosedForms, WhereAllSlidesItSlidesAsFarAsTheIndenterGoes) {
  const Incompressible s;
  const std::vector<PadStep> steps = s.path({{1, 0, 0}, {1.5, 0, 0}, {1.25, 0, 0}, {0, 0, 0}}, 12, s.mu);
  EXPECT_EQ(steps[0].slid, 0);
  EXPECT_NEAR(steps[2].slid - steps[1].slid, 0.5, 1e-6);
  EXPECT_NEAR(steps[2].slip_path - steps[1].slip_path, 0.5, 1e-6);
  // Back by far more than the contact's 0.01, in one increment: the way less what the rubber goes back. That is twice
  // `sliding` in the middle and, as u_x = pi q (6 a^2 - 2.5 x^2 - 3.5 y^2) / (32 G a) under a Hertzian shear (Johnson,
  // Contact Mechanics, 7.2), 3/4 of it in the mean.
  EXPECT_NEAR(steps[4].slid - steps[3].slid, 1.25, 1e-6);
  const double sliding = 3 * s.mu * steps[0].P * (2 - s.nu) / (16 * s.a) * 2 * (1 + s.nu);  // G = E / 2 (1 + nu), E = 1
  EXPECT_NEAR(steps[3].slid - steps[2].slid, 0.25 - 1.5 * sliding, 0.1 * sliding);
  const std::vector<PadStep> sticks = s.path({{0.9 * sliding, 0, 0}, {-0.8 * sliding, 0, 0}}, 12, s.mu);
  for (const PadStep& step : sticks) EXPECT_EQ(step.slid, 0);
  // Cells at the rim slip, both ways, each less than the indenter moves.
  EXPECT_GT(sticks[1].slip_path, sticks[0].slip_path + 0.1 * sliding);
  EXPECT_GT(sticks[2].slip_path, sticks[1].slip_path + 0.1 * sliding);
  EXPECT_LT(sticks[2].slip_path, 2.6 * sliding);
}

TEST(PadClosedForms, CattaneoMindlin) {
  // Q / (mu P) = 1 - (1 - shift / sliding)^(3/2), sliding = 3 mu P (2 - nu) / (16 a G), one direction of slip.
  const Incompressible s;
  const double P = 16.0 / 9 * std::sqrt(s.R) * std::pow(s.d, 1.5), G = 1 / (2 * (1 + s.nu));
  const double sliding = 3 * s.mu * P * (2 - s.nu) / (16 * s.a * G);
  for (const double part : {0.2, 0.4, 0.6, 0.8}) {
    const PadStep step = s.after({part * sliding, 0, 0}, 12);
    EXPECT_NEAR(step.Q[0] / (s.mu * step.P), 1 - std::pow(1 - part, 1.5), 0.005) << part;
    EXPECT_NEAR(step.slip_index.value(), step.force_ratio.value(), 1e-6);  // no torque
  }
}

TEST(PadClosedForms, Torsion) {
  const Incompressible s;
  const PadStep step = s.after({0, 0, 1}, 12);  // far beyond sliding
  EXPECT_NEAR(step.M / (s.mu * step.P * s.a), 3 * pi / 16, 0.005 * 3 * pi / 16);
  EXPECT_NEAR(step.slip_index.value(), 1, 1e-4);
  EXPECT_NEAR(step.force_ratio.value(), 0, 1e-6);  // the sweeps' tolerance
}

TEST(PadClosedForms, FlatRoundPunch) {
  const double nu = 0.3, a = 1, d = 0.1;
  const PadScene scene = scene_of(Punch{a, 0}, d, 1000 * a, nu, 0, {});
  const PadLayer layer(nu);
  const double P = 2 * a * d / (1 - nu * nu);
  for (const int n : {8, 12, 16}) {
    const PadStep step = PadSolver(layer, {.cells = n, .tolerance = 1e-6}).solve(scene).steps.back();
    EXPECT_NEAR(step.P / P, 1, 0.008) << n;  // cells over the punch alone are 3 % low at 8
  }
}

TEST(PadClosedForms, SlidingAsAWholeIsTheLimit) {
  const Incompressible s;
  for (const std::array<double, 3> drag : {std::array{1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.02, 0.01, 1.0}}) {
    EXPECT_NEAR(s.after(drag, 12).slip_index.value(), 1, 1e-4);
    EXPECT_EQ(s.after(drag, 12).stick_fraction, 0);
  }
}

/// Nearly incompressible rubber under a contact some H wide, whose slow modes change by less than the sweeps' tolerance
/// while the laws are still off by 1e-5.
TEST(PadSolver, SweepsGoOnUntilTheLawsHold) {
  for (const double nu : {0.49, 0.5}) {
    const PadScene scene = scene_of(Paraboloid{{100, 100}}, 0.08, 1, nu, 0.5, {{0.1, 0, 0}, {0.3, 0, 0.017}});
    const PadLayer layer(nu);
    const PadSolution solution = PadSolver(layer, {.cells = 8, .tolerance = 1e-7, .accept = 1e-6}).solve(scene),
                      exact = PadSolver(layer, {.cells = 8, .tolerance = 1e-12, .accept = 1e-6}).solve(scene);
    for (std::size_t k = 0; k < exact.steps.size(); ++k) {
      const PadStep &step = solution.steps[k], &to = exact.steps[k];
      EXPECT_TRUE(step.converged) << nu << " " << k << ": " << step.residual.largest();
      EXPECT_LE(step.residual.largest(), 1e-6) << nu << " " << k;
      EXPECT_NEAR(step.P / to.P, 1, 2e-5) << nu << " " << k;  // P of a thin layer changes some times as much as gaps
      EXPECT_NEAR(step.slip_index.value(), to.slip_index.value(), 2e-5) << nu << " " << k;
    }
  }
}

/// A tilted box on nearly incompressible rubber, whose halved steps still go round in circles. Dragged far, all slides.
TEST(PadSolver, SweepsThatGoRoundInCirclesAreDampedUntilTheySettle) {
  PadScene scene = scene_of(Box{{5.4, 2.75}, 0.27}, 0.0286, 2, 0.489, 3, {{0.2, 0, 0}, {0.4, 0, 0}});
  scene.indenter.tilt = 0.2, scene.indenter.tilt_direction = 312;
  const PadLayer layer(scene.sensor.poisson);
  const PadSolution solution = PadSolver(layer, {.cells = 16, .tolerance = 1e-4, .limit_increments = 2}).solve(scene);
  for (const PadStep& step : solution.steps) EXPECT_TRUE(step.converged) << step.residual.largest();
  EXPECT_NEAR(solution.steps.back().slip_index.value(), 1, 1e-3);  // of 16 x 16 cells
  EXPECT_EQ(solution.steps.back().stick_fraction, 0);
}

/// Of an increment that does not settle, whose force is then not that of its depth.
TEST(PadSolver, ASearchForADepthEndsWithTheFirstTrialThatDoesNotSettle) {
  PadScene scene = scene_of(Paraboloid{{12, 4}}, 0, 3, .3, .3, {{.02, .03, 0}, {.05, .06, .02}});
  scene.load.indentation.clear(), scene.load.normal_force = {0.5};
  const PadLayer layer(scene.sensor.poisson);
  const PadOptions options{.cells = 8, .most_sweeps = 1};
  const PadSolution solution = PadSolver(layer, options).solve(scene);
  int sweeps = 0;
  for (const PadStep& step : solution.steps) {
    sweeps += step.iterations;
    EXPECT_FALSE(step.converged);
  }
  EXPECT_EQ(sweeps, static_cast<int>(pad_increments(scene, options, solution.cells).size()));  // one each
  PadOptions part = options;
  part.whole_path = false;
  const PadSolution first = PadSolver(layer, part).solve(scene);
  ASSERT_EQ(first.steps.size(), solution.steps.size());
  for (std::size_t k = 0; k < first.steps.size(); ++k) EXPECT_EQ(first.steps[k].iterations, k == 0 ? 1 : 0) << k;
}

/// A pillar on a plain, whose force grows with a high power of the depth where the plain begins to bear.
TEST(PadSolver, ASearchForAForceEndsBelowAPillarOnAPlain) {
  HeightMap map{.pitch = 0.338, .heights = Eigen::MatrixXd::Constant(21, 21, 0.15)};
  map.heights.block(6, 8, 3, 3).setZero();
  PadScene scene = scene_of(map, 0, 2, 0.1, 0.5, {});
  scene.load.indentation.clear(), scene.load.normal_force = {1.2};
  const PadLayer layer(scene.sensor.poisson);
  for (const double tolerance : {1e-3, 1e-7}) {
    const PadSolution solution = PadSolver(layer, {.cells = 8, .tolerance = tolerance}).solve(scene);
    for (const auto& [k, P] : {std::pair{0, 0.6}, {1, 1.2}}) {
      EXPECT_TRUE(solution.steps[k].converged) << tolerance << " " << k;
      EXPECT_NEAR(solution.steps[k].P / P, 1, tolerance) << k;
    }
  }
}

TEST(PadSolver, WhatHoldsAtOnceKeepsItsBits) {
  const PadScene scene = scene_of(Paraboloid{{12, 4}}, .2, 3, .3, .3, {{.02, .03, 0}, {.05, .06, .02}});
  const PadLayer layer(scene.sensor.poisson);
  const PadSolution solution = PadSolver(layer, {.cells = 8, .tolerance = 1e-7, .accept = 1e-6}).solve(scene),
                    at_once = PadSolver(layer, {.cells = 8, .tolerance = 1e-7, .accept = 1}).solve(scene);
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    const PadStep &a = solution.steps[k], &b = at_once.steps[k];
    EXPECT_EQ(a.iterations, b.iterations) << k;
    EXPECT_EQ(a.normal_force, b.normal_force) << k;
    EXPECT_EQ(a.tangential_force, b.tangential_force) << k;
  }
}

PadScene turned(const PadScene& scene) {  // by 90 degrees
  PadScene to = scene;
  const auto& p = std::get<Paraboloid>(scene.indenter.shape);
  to.indenter.shape = Paraboloid{{p.radii[1], p.radii[0]}};
  for (auto& drag : to.load.drags) drag = {-drag[1], drag[0], drag[2]};
  return to;
}

PadScene mirrored(const PadScene& scene) {  // y to -y
  PadScene to = scene;
  for (auto& drag : to.load.drags) drag = {drag[0], -drag[1], -drag[2]};
  return to;
}

TEST(PadSymmetry, TurningAndMirroringAScene) {
  const PadScene scene = scene_of(Paraboloid{{12, 4}}, .2, 3, .3, .3, {{.02, .03, 0}, {.05, .06, .02}});
  const PadLayer layer(scene.sensor.poisson);
  const PadSolver solver(layer, {.cells = 10, .tolerance = 1e-12});
  const PadStep step = solver.solve(scene).steps.back(), turn = solver.solve(turned(scene)).steps.back(),
                mirror = solver.solve(mirrored(scene)).steps.back();
  const double near = 1e-9;  // sweeps are not symmetric; they end at 1e-12
  EXPECT_NEAR(turn.P, step.P, near);
  EXPECT_NEAR(turn.Q[0], -step.Q[1], near);
  EXPECT_NEAR(turn.Q[1], step.Q[0], near);
  EXPECT_NEAR(turn.M, step.M, near);
  EXPECT_NEAR(*turn.slip_index, *step.slip_index, near);
  EXPECT_NEAR(mirror.P, step.P, near);
  EXPECT_NEAR(mirror.Q[0], step.Q[0], near);
  EXPECT_NEAR(mirror.Q[1], -step.Q[1], near);
  EXPECT_NEAR(mirror.M, -step.M, near);
}

TEST(PadSymmetry, YawTurnsTheAnswer) {
  PadScene scene = scene_of(Box{{1, 0.6}, 0.4}, .2, 2, .45, .5, {{.03, .02, .01}});
  scene.sensor.tactels = {1, 1};
  const PadLayer layer(scene.sensor.poisson);
  const PadSolver solver(layer, {.tolerance = 1e-10});
  const PadStep straight = solver.solve(scene).steps.back();
  scene.indenter.yaw = 90;
  scene.load.drags = {{-.02, .03, .01}};
  const PadStep yawed = solver.solve(scene).steps.back();
  EXPECT_NEAR(yawed.Q[0], -straight.Q[1], 1e-9);
  EXPECT_NEAR(yawed.Q[1], straight.Q[0], 1e-9);
  EXPECT_NEAR(yawed.stress(0, 0), straight.stress(0, 0), 1e-9);
  EXPECT_NEAR(yawed.stress(0, 1), -straight.stress(0, 2), 1e-9);
  EXPECT_NEAR(yawed.stress(0, 2), straight.stress(0, 1), 1e-9);
}

TEST(PadSolver, CertifiesWhatItSolves) {
  for (const double poisson : {0.3, 0.5}) {
    PadSensor sensor;
    sensor.poisson = poisson;
    const PadLayer layer(poisson);
    PadMix mix(3, &sensor);
    for (int k = 0; k < 18; ++k) {
      for (const PadStep& step : PadSolver(layer, {.cells = 8}).solve(mix()).steps) {
        EXPECT_TRUE(step.converged) << k << ": " << step.residual.largest();
        EXPECT_LE(step.slip_index.value_or(0), 1 + 1e-6);
        EXPECT_GE(step.slip_index.value_or(0) + 1e-6, step.force_ratio.value_or(0)) << k;  // torque only adds
      }
    }
  }
}

TEST(PadSolver, ReachesGivenForces) {
  for (const PadShape& shape : {PadShape(Sphere{8}), PadShape(Box{{1, 1}, 0}), PadShape(Cone{75})}) {
    PadScene scene = scene_of(shape, 0, 2, .45, .5, {{.05, .02, .01}, {.1, .04, .03}});
    scene.load.indentation = {};
    scene.load.normal_force = {0.7, 0.3};
    scene.load.indentation_steps = 1;
    const PadLayer layer(scene.sensor.poisson);
    const PadSolution solution = PadSolver(layer).solve(scene);
    ASSERT_EQ(solution.steps.size(), 4u);
    EXPECT_NEAR(solution.steps[0].P, 0.7, 0.7e-3);
    for (int k = 1; k < 4; ++k) EXPECT_NEAR(solution.steps[k].P, 0.3, 0.3e-3);
    for (const PadStep& step : solution.steps) EXPECT_TRUE(step.converged) << step.residual.largest();
  }
}

// Cells two thicknesses wide have 5 parts a side: 25 of their own, each with its 5 x 5 around it, or (8 + 4) 5 along a
// row of 8 together. Some 20 points a part.
TEST(PadSolver, WideCellsShareThePartsOfTheirBaseStress) {
  const PadScene scene = scene_of(Paraboloid{{90, 90}}, 0.1, 1, 0.48, 0.5, {});
  const double tactels = scene.sensor.tactels[0] * scene.sensor.tactels[1];
  EXPECT_LE(base_stress_work(scene, {.n = 8, .hx = 2, .hy = 2}), tactels * 20 * std::pow((8 + 4) * 5, 2));
}

TEST(PadSolver, AnIndenterThatDoesNotTouchBearsNothing) {
  PadScene scene = scene_of(Sphere{8}, .25, 2, .45, .5, {});
  scene.load.indentation = {.25, 0};
  const PadLayer layer(scene.sensor.poisson);
  const PadStep step = PadSolver(layer).solve(scene).steps.back();
  EXPECT_EQ(step.P, 0);
  EXPECT_FALSE(step.slip_index.has_value());
  EXPECT_TRUE(step.converged);
}

/// A denormal Poisson's ratio once made every number NaN, and every residual 0.
TEST(PadSolver, WhatIsNotFiniteHasNotConverged) {
  const PadScene scene = scene_of(Sphere{8}, .25, 2, 1e-310, .5, {{.02, 0, 0}});
  const PadLayer layer(scene.sensor.poisson);
  for (const PadStep& step : PadSolver(layer).solve_on({.n = 12, .hx = 0.3, .hy = 0.3}, scene).steps)
    EXPECT_TRUE(std::isfinite(step.P) || !step.converged);
}

TEST(PadLayers, RatiosNextToAPointAreThoseOfThePoint) {
  for (const double tiny : {1e-310, 1e-308, 1e-291}) {
    EXPECT_EQ(pad_layer(tiny).displacements(1.5)[0], pad_layer(0).displacements(1.5)[0]) << tiny;
    EXPECT_EQ(poisson_shares(tiny), poisson_shares(0)) << tiny;
  }
}

// Sneddon: a cone on a half-space, P = 2 E' d^2 tan(angle) / pi. Each depth as exactly as alone: 12 cells leave 0.8 %
// of P, and H = 100 a some 0.5 % of it.
TEST(PadSolver, StepsOfThePressingAreAsExactAsAlone) {
  const double nu = 0.3, angle = 80, deepest = 0.01;
  PadScene scene = scene_of(Cone{angle}, deepest, 10, nu, 0, {{0.001, 0, 0}});
  scene.load.indentation.clear();
  for (const double part : {0.03, 0.07, 0.13, 0.27, 0.5, 1.0}) scene.load.indentation.push_back(part * deepest);
  scene.load.indentation_steps = 1;
  const PadLayer layer(nu);
  const PadSolution solution = PadSolver(layer).solve(scene);
  ASSERT_EQ(solution.steps.size(), 7u);
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    const PadStep& step = solution.steps[k];
    const double d = scene.load.indentation[std::min<std::size_t>(k, 5)];
    EXPECT_NEAR(step.P / (2 * d * d * std::tan(angle * pi / 180) / (pi * (1 - nu * nu))), 1, 0.015) << k;
    EXPECT_NEAR(step.normal_force.sum(), step.P, 1e-12 * step.P) << k;
    EXPECT_EQ(step.normal_force.size(), solution.places.rows());
    EXPECT_TRUE(step.converged) << k;
    EXPECT_EQ(step.indentation, d) << k;
    EXPECT_GE(step.across, least_across(12, 12)) << k;
  }
}

// With friction, too, a press in steps leads where one in many leads: what the last of them leaves of the first ones'
// history, on few cells, is small beside the same on cells of their own.
TEST(PadSolver, APressOnItsWayIsThatPressAlone) {
  PadScene scene = scene_of(Sphere{8}, .25, 2, .45, .5, {});
  scene.load = {.indentation = {.03, .06, .25}};
  const PadLayer layer(.45);
  const PadOptions fine{.cells = 48, .tolerance = 1e-5, .ladder = false};
  const PadLayout laid = lay_cells(scene, layer, 48, false);
  const PadSolution on_the_way = PadSolver(layer, fine).solve_on(laid.cells, scene);
  const PadSolution now = PadSolver(layer).solve(scene);
  for (const std::size_t k : {0u, 1u}) {
    const PadStep &a = now.steps[k], &b = on_the_way.steps[k];
    EXPECT_NEAR(a.P / b.P, 1, 0.01) << k;  // 12 cells alone; 16 and 23 of the 48
    EXPECT_LT((a.stress - b.stress).cwiseAbs().maxCoeff(), 0.02 * b.stress.cwiseAbs().maxCoeff()) << k;
  }
}

TEST(PadSolver, ADragHoldsItsCells) {
  // Lifted after a drag, the contact has a history of friction, and stays on the cells of the deepest step.
  PadScene scene = scene_of(Cone{80}, .1, 2, .45, .5, {});
  scene.load = {.indentation = {.1}, .moves = {{.1, .01, 0, 0}, {.02, .01, 0, 0}}};
  const PadLayer layer(.45);
  const PadSolution now = PadSolver(layer).solve(scene);
  EXPECT_LT(now.steps.back().across, least_across(12, 12));
  EXPECT_TRUE(coarse_presses(scene, now).empty());
}

TEST(PadSolver, GrowsWhereTheSurfaceIsPenetratedBeyondTheCells) {
  const PadScene scene = scene_of(Sphere{8}, .25, 2, .45, .5, {});
  const PadLayer layer(scene.sensor.poisson);
  const PadSolver solver(layer, {.ladder = false});
  const PadCells small{.n = 12, .hx = 0.1, .hy = 0.2};
  const PadSolution solution = solver.solve_on(small, scene);
  EXPECT_EQ(solution.outside, (std::array{true, true, true, true}));
  EXPECT_FALSE(solution.steps.back().converged);
  const PadCells more = grown(small, {true, false, false, true}, scene, false);
  EXPECT_NEAR(more.box().x.left, small.box().x.left - 0.15, 1e-12);
  EXPECT_NEAR(more.box().x.right, small.box().x.right, 1e-12);
  EXPECT_NEAR(more.box().y.right, small.box().y.right + 0.3, 1e-12);
}

/// Drags inside which the slip turns, by an independent program: 40 x 40 cells, increments extrapolated, S to 0.003.
struct TurningSlip {
  const char* name;
  PadScene scene;
  double yaw, error;  ///< of 12 x 12 cells where slip does not turn, 95 % of such shapes
  std::vector<double> S;
};

const std::vector<TurningSlip>& turning_slips() {
  static const std::vector<TurningSlip> all = {
      {"twisted",
       scene_of(Paraboloid{{73.98, 71.1558}}, 0.2407, 3.175, 0.5, 0.1137,
                {{0.0, 0.0, 0.00833246},
                 {0.0, 0.0, 0.0149985},
                 {0.0, 0.0, 0.0216644},
                 {0.0, 0.0, 0.0283304},
                 {0.0, 0.0, 0.0349964},
                 {0.0, 0.0, 0.0416624}}),
       132.04,
       0.0107,
       {0.466, 0.6618, 0.7816, 0.8572, 0.9059, 0.9375}},
      {"on_a_loop",
       scene_of(Paraboloid{{4.4514, 2.0021}}, 0.4095, 2.093, 0.4, 0.133,
                {{0.0408007, 0.0172503, 0.0365479},
                 {0.0541792, 0.074184, -0.0211973},
                 {0.0102717, 0.1128178, -0.0129893},
                 {-0.0444965, 0.0923024, 0.0356336},
                 {-0.0522166, 0.0343297, -0.0266138},
                 {-0.0047258, 0.0001967, -0.00605507}}),
       -171.13,
       0.0107,
       {0.8071, 0.9655, 0.971, 0.9484, 0.8329, 0.6368}},
      {"back",
       scene_of(Punch{0.9012, 0.222}, 0.9498, 4.803, 0.3, 0.162,
                {{-0.1229579, 0.1102933, 0},
                 {-0.2459158, 0.2205866, 0},
                 {-0.1475495, 0.1323519, 0},
                 {-0.0245916, 0.0220587, 0},
                 {0.0983663, -0.0882346, 0},
                 {-0.0, 0.0, 0}}),
       68.89,
       0.0131,
       {0.693, 0.9911, 0.2844, 0.5204, 0.9984, 0.291}},
  };
  return all;
}

TEST(PadSolver, SubstepsFollowSlipThatTurnsWithinADrag) {
  for (const auto& [name, given, yaw, error, S] : turning_slips()) {
    PadScene scene = given;
    scene.indenter.yaw = yaw;
    scene.load.indentation_steps = 1;
    const PadLayer layer(scene.sensor.poisson);
    const PadSolution solution = PadSolver(layer).solve(scene);
    ASSERT_EQ(solution.steps.size(), S.size() + 1);
    for (std::size_t k = 0; k < S.size(); ++k) EXPECT_NEAR(*solution.steps[k + 1].slip_index, S[k], error) << name << k;
  }
}

TEST(PadSolver, SubstepsConvergeAtFirstOrder) {
  double off[2] = {};
  for (const TurningSlip& of : turning_slips()) {
    const PadLayer layer(of.scene.sensor.poisson);
    const PadLayout laid = lay_cells(of.scene, layer, 8, true);
    const auto solved = [&](int limit_increments) {
      return PadSolver(layer, {.cells = 8, .tolerance = 1e-6, .limit_increments = limit_increments})
          .solve_on(laid.cells, of.scene);
    };
    const std::array paths = {solved(8), solved(16), solved(32)};
    for (const int k : {0, 1}) off[k] += pad_difference(paths[k], paths[k + 1]).S;
  }
  EXPECT_NEAR(off[0] / off[1], 2, 0.4);  // errors c / increments; numbers of increments are rounded up
}

TEST(PadSolver, ADragTakesAsManyIncrementsAsItMovesAgainstTheSlidingLimit) {
  // Half a side of the cells is 1 mm; mu d (2 - nu) / (2 (1 - nu)) = 0.3 mm, for which 12 cells take four increments.
  PadScene scene = scene_of(Sphere{8}, .2, 2, .5, 1, {});
  const PadCells cells{.n = 12, .hx = 1. / 6, .hy = 1. / 6};
  scene.load.drags = {{.06, 0, 0}, {.36, 0, 0}, {.36, 0, .15}, {10, 0, .15}, {10, 0, .15}, {9.85, 0, .15}};
  const auto counts = [&](const PadOptions& options) {
    std::vector<int> all(1);
    for (const PadIncrement& i : pad_increments(scene, options, cells)) {
      ++all.back();
      if (i.asked) all.push_back(0);
    }
    return all;
  };
  // Pressing; less than a quarter; one limit; half of one, across; far; a pause; half of one, back.
  EXPECT_EQ(counts({.cells = 12}), (std::vector{2, 2, 1, 4, 8, 8, 1, 2, 0}));
  EXPECT_EQ(counts({.cells = 12, .limit_increments = 0}), (std::vector{2, 2, 1, 1, 1, 1, 1, 1, 0}));
  EXPECT_EQ(counts({.cells = 12, .drag_increments = 2, .parts = 2}), (std::vector{4, 4, 4, 8, 16, 16, 4, 4, 0}));
  scene.friction = 0;
  EXPECT_EQ(counts({.cells = 12}), (std::vector{2, 2, 1, 1, 1, 1, 1, 1, 0}));
  // By a force of 1 N on a half-space, G = 1 MPa, a = 2 / sqrt(pi): 1.5 (2 - nu) / (8 G a).
  scene.friction = 1, scene.sensor.young = 3, scene.sensor.thickness = 1e9, scene.load.normal_force = {1};
  EXPECT_NEAR(sliding_limit(scene, 1, cells), 0.249251, 1e-6);
}

}  // namespace tactel::fem::pad_solver_test
