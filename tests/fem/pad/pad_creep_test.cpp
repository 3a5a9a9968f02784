// SPDX-License-Identifier: Apache-2.0

// Steps on rubber that creeps: an independent program's path, and what convolution makes of elastic contacts.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "fem/numbers/value_error.h"
#include "fem/pad/creep.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_step.h"

namespace tactel::fem::pad_creep_test {

const PadOptions exact{.cells = 16, .tolerance = 1e-10, .accept = 1e-7};
const std::vector<std::array<double, 2>> gel{{0.15, 0.3}, {0.10, 3.0}};

SteppedContact sphere_on(const PadSensor& sensor, double mu) {
  SteppedContact steps(pad_layer(sensor.poisson), sensor, fixed_cells(16, 0.2), mu, exact);
  steps.set_surface(pad_surface(fixed_cells(16, 0.2), {.shape = Sphere{8}}, {0, 0}, 0));
  return steps;
}
PadSensor rubber_of(const std::vector<std::array<double, 2>>& relaxation) {
  return {.thickness = 2, .young = 1, .poisson = 0.45, .relaxation = relaxation};
}

struct Known {
  double dt, depth;
  PadMotion motion;
  double P, Qx, Qy, M, S;
};
const std::vector<Known>& known_path() {
  static const std::vector<Known> path = {
      {.1, .125, {0, 0, 0}, .40191226, 0, 0, 0, 0},
      {.1, .25, {0, 0, 0}, 1.51451775, 0, 0, 0, 0},
      {.1, .25, {.05, .02, .01}, 1.45605529, .20475504, .08206531, .07974201, .33105},
      {.1, .25, {.1, .04, .03}, 1.41110404, .36077421, .14586795, .17741192, .62833},
      {1, .25, {.1, .04, .03}, 1.27601411, .30979240, .12523228, .15168067, .59629},
      {10, .25, {.1, .04, .03}, 1.17474593, .28383748, .11473853, .13892667, .59341},
      {.1, .25, {.1, .1, .05}, 1.17304070, .24750954, .30538161, .19977479, .78311},
      {.1, .15, {.1, .1, .05}, .28594576, .09109402, .10479414, .01801678, .99953}};
  return path;
}

TEST(CreepingContact, WalksThePathOfAnIndependentProgram) {
  SteppedContact steps = sphere_on(rubber_of(gel), 0.5);
  int step = 0;
  for (const Known& at : known_path()) {
    steps.dt = at.dt;
    const SteppedState s = steps.move(at.depth, at.motion);
    EXPECT_NEAR(s.force[0], at.P, 2e-8) << ++step;
    EXPECT_NEAR(s.force[1], at.Qx, 2e-8) << step;
    EXPECT_NEAR(s.force[2], at.Qy, 2e-8) << step;
    EXPECT_NEAR(s.force[3], at.M, 2e-8) << step;
    EXPECT_NEAR(s.slip_index, at.S, 6e-6) << step;
  }
}

// A path with times is these steps: pressed twice, dragged, held, dragged on.
TEST(CreepingContact, PathsHaveTimes) {
  PadScene scene;
  scene.sensor = rubber_of(gel), scene.indenter.shape = Sphere{8}, scene.friction = 0.5;
  scene.load = {.indentation = {0.25}, .indentation_steps = 2, .times = {.1, .2, .3, .4, 1.4, 11.4, 11.5}};
  for (std::size_t k = 2; k < 7; ++k) {
    const PadMotion& to = known_path()[k].motion;
    scene.load.drags.push_back({to[0], to[1], to[2]});
  }
  scene.validate();
  PadOptions options = exact;
  options.pressing_increments = 2, options.limit_increments = 0;
  const PadSolution path = PadSolver(pad_layer(0.45), options).solve_on({.n = 16, .hx = 0.2, .hy = 0.2}, scene);
  ASSERT_EQ(path.steps.size(), 7u);
  for (std::size_t k = 0; k < 7; ++k) {
    EXPECT_NEAR(path.steps[k].P, known_path()[k].P, 2e-8) << k;
    EXPECT_NEAR(path.steps[k].Q[0], known_path()[k].Qx, 2e-8) << k;
    EXPECT_NEAR(path.steps[k].M, known_path()[k].M, 2e-8) << k;
    EXPECT_NEAR(path.steps[k].slip_index.value_or(0), known_path()[k].S, 6e-6) << k;
  }
  // By force it sinks.
  scene.load = {.indentation = {}, .normal_force = {1}, .drags = {{0, 0, 0}, {0, 0, 0}}, .times = {0.1, 1, 100}};
  const PadSolution held = PadSolver(pad_layer(0.45), exact).solve(scene);
  for (const PadStep& step : held.steps) EXPECT_NEAR(step.P, 1, 1e-6);
  EXPECT_GT(held.steps[1].indentation, 1.03 * held.steps[0].indentation);
  EXPECT_GT(held.steps[2].indentation, 1.05 * held.steps[1].indentation);
}

// What a ball that sticks holds does not move, however its force falls: markers of the surface, and how far it slides.
TEST(CreepingContact, MarkersGoWithTheObjectThatTheyStickTo) {
  PadScene scene;
  scene.sensor = rubber_of(gel), scene.indenter.shape = Sphere{8}, scene.friction = 50;
  scene.load = {
      .indentation = {0.25}, .drags = {{.05, .02, 0}, {.05, .02, 0}, {.05, .02, 0}}, .times = {.1, .2, 1, 30}};
  scene.markers = Markers{.depth = 0, .places = {{0, 0}, {0.2, 0.2}}};
  const PadLayer layer = pad_layer(0.45);
  PadSolution held = PadSolver(layer, exact).solve(scene);
  see_markers(scene, held);
  EXPECT_LT(held.steps[3].P, 0.85 * held.steps[0].P);
  for (std::size_t k = 1; k < 4; ++k) {
    const PadStep& step = held.steps[k];
    ASSERT_EQ(step.stick_fraction, 1) << k;
    for (const Eigen::Index m : {0, 1}) {  // tractions are even over cells of 0.2 mm
      EXPECT_NEAR(step.markers(m, 0), 0.05, 1e-3) << k;
      EXPECT_NEAR(step.markers(m, 1), 0.02, 1e-3) << k;
      EXPECT_NEAR(step.markers(m, 2), -0.25 + static_cast<double>(m) * 0.005, 2e-3) << k;
    }
    EXPECT_NEAR(step.slip_distance, held.steps[0].slip_distance, 1e-3) << k;
  }
}

// Without friction, while it grows: what an increment of the elastic force leaves of itself later is E(t) / E (E. H.
// Lee, J. R. M. Radok, J. Appl. Mech. 27, 1960, 438-444). Straight pieces of time leave the square of their length.
TEST(CreepingContact, GrowsAsTheConvolutionOfTheElasticOne) {
  const auto worst = [](double dt) {
    SteppedContact creeping = sphere_on(rubber_of(gel), 0), elastic = sphere_on(rubber_of({}), 0);
    creeping.dt = dt;
    const int count = static_cast<int>(std::lround(2 / dt));
    std::vector<double> force{0};
    double most = 0;
    for (int k = 1; k <= count; ++k) {
      const double depth = 0.25 * std::min(1.0, k * dt);
      force.push_back(elastic.move(depth, {0, 0, 0}).force[0]);
      double P = 0;
      for (int i = 1; i <= k; ++i) {  // of the middle of each piece
        double E = 1;
        for (const auto& [g, tau] : gel) E -= g * -std::expm1(-(k - i + 0.5) * dt / tau);
        P += E * (force[static_cast<std::size_t>(i)] - force[static_cast<std::size_t>(i - 1)]);
      }
      most = std::max(most, std::abs(creeping.move(depth, {0, 0, 0}).force[0] - P));
    }
    return most / force.back();
  };
  const double coarse = worst(0.1), fine = worst(0.05);
  EXPECT_LT(fine, 1e-3);
  EXPECT_LT(fine, 0.6 * coarse);
}

// A force that is held sinks to the depth at which it is J(t) times as large without creep.
TEST(CreepingContact, SinksUnderAConstantForce) {
  SteppedContact creeping = sphere_on(rubber_of(gel), 0);
  constexpr double P = 0.8;
  creeping.dt = 0;
  creeping.press({P, 0, 0, 0}, 1e-7);
  const Creep law(gel);
  double t = 0;
  for (int k = 0; k < 12; ++k) {
    creeping.dt = k < 8 ? 0.05 : 5;
    t += creeping.dt;
    creeping.press({P, 0, 0, 0}, 1e-7);
  }
  double J = 1;
  for (const auto& [c, theta] : law.terms()) J += c * -std::expm1(-t / theta);
  SteppedContact elastic = sphere_on(rubber_of({}), 0);
  elastic.press({J * P, 0, 0, 0}, 1e-7);
  EXPECT_NEAR(creeping.depth(), elastic.depth(), 1e-3 * elastic.depth());
}

// In no time rubber is elastic, in all time as soft as it ends.
TEST(CreepingContact, IsElasticAtBothEndsOfTime) {
  SteppedContact elastic = sphere_on(rubber_of({}), 0.5);
  const double P = elastic.move(0.2, {0, 0, 0}).force[0], Q = elastic.move(0.2, {0.04, 0, 0}).force[1];
  for (const auto& [dt, part] : {std::pair{0.0, 1.0}, {1e-9, 1.0}, {1e9, 0.75}}) {
    SteppedContact creeping = sphere_on(rubber_of(gel), 0.5);
    creeping.dt = dt;
    EXPECT_NEAR(creeping.move(0.2, {0, 0, 0}).force[0], part * P, 2e-8) << dt;
    EXPECT_NEAR(creeping.move(0.2, {0.04, 0, 0}).force[1], part * Q, 2e-8) << dt;
  }
}

// Jumps between steps of nanoseconds and of decades: forces stay within those of rubber that has not crept.
TEST(CreepingContact, IsBoundedOverAllTimes) {
  SteppedContact steps = sphere_on(rubber_of(gel), 0.5);
  SteppedContact elastic = sphere_on(rubber_of({}), 0.5);
  const double most = elastic.move(0.25, {0, 0, 0}).force[0];
  std::uint32_t random = 1;
  const auto part = [&] { return (random = random * 1664525u + 1013904223u) / 4294967296.0; };
  for (int k = 0; k < 120; ++k) {
    steps.dt = std::pow(10, 18 * part() - 9);
    const SteppedState s = steps.move(0.25 * part(), {0.1 * part(), 0.1 * part(), 0.05 * part()});
    EXPECT_TRUE(s.met) << k;
    EXPECT_GE(s.force[0], 0);
    EXPECT_LE(s.force[0], most * (1 + 1e-6)) << k;
    EXPECT_LE(s.slip_index, 1);
  }
}

TEST(CreepingContact, RelaxationIsChecked) {
  const auto key_of = [](const std::vector<std::array<double, 2>>& terms) -> std::string {
    try {
      validate(rubber_of(terms));
    } catch (const ValueError& error) {
      return error.key;
    }
    return "";
  };
  EXPECT_EQ(key_of(gel), "");
  for (const auto& wrong :
       std::vector<std::vector<std::array<double, 2>>>{{{0, 1}},
                                                       {{-0.1, 1}},
                                                       {{1, 1}},
                                                       {{0.6, 1}, {0.5, 2}},
                                                       {{0.1, 0}},
                                                       {{0.1, std::nan("")}},
                                                       {{std::nan(""), 1}},
                                                       {{0.1, 2}, {0.1, 2}},
                                                       {{0.1, 1}, {0.1, 2}, {0.1, 3}, {0.1, 4}, {0.1, 5}}})
    EXPECT_EQ(key_of(wrong), "sensor.relaxation");
  PadScene scene;
  scene.sensor = rubber_of(gel);
  EXPECT_THROW(PadSolver(pad_layer(0.45)).solve(scene), ValueError) << "without times";
  scene.load.times = {1, 2};
  EXPECT_THROW(scene.validate(), ValueError) << "of one step";
  scene.load.times = {-1};
  EXPECT_THROW(scene.validate(), ValueError);
  scene.load.times = {1};
  scene.validate();
  scene.sensor.relaxation.clear();
  EXPECT_THROW(scene.validate(), ValueError) << "elastic";
}

}  // namespace tactel::fem::pad_creep_test
