// SPDX-License-Identifier: Apache-2.0

// Steps of the kernel on rubber that creeps beside their twin, and the bits of their states.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_step.h"
#include "tests/host/contact/stepped.h"

namespace tactel::host::pad_step_creep_test {

constexpr std::size_t count = 3;

fem::PadSensor gel() {
  fem::PadSensor pad = rubber;
  pad.relaxation = {{0.2, 0.4}, {0.1, 4.0}};
  return pad;
}

StepOptions options_of(double tolerance) {
  return {
      .cells = {10, 12}, .cell = {0.28, 0.25}, .tolerance = tolerance, .force_tolerance = 1e-7, .most_sweeps = 3000};
}

/// Objects of different size; one is a box whose edges cover cells in part.
fem::PadIndenter object(std::size_t c) {
  if (c == 2) return {.shape = fem::Box{{0.8, 0.7}}};
  return {.shape = fem::Sphere{c == 0 ? 6.0 : 3.0}};
}

template <class Real>
void put(PadStepper<Real>& steps) {
  for (std::size_t c = 0; c < count; ++c) steps.set_surface(c, fem::pad_surface(steps.cells(), object(c), {0, 0}, 0));
}

/// The twins of these contacts.
std::vector<fem::SteppedContact> twins_on(const fem::PadCells& cells, double tolerance) {
  std::vector<fem::SteppedContact> twins;
  twins.reserve(count);
  for (std::size_t c = 0; c < count; ++c) {
    twins.emplace_back(fem::pad_layer(rubber.poisson), gel(), cells, 0.5,
                       fem::PadOptions{.cells = 12, .tolerance = tolerance, .accept = 1e-6, .most_sweeps = 4000});
    twins.back().set_surface(fem::pad_surface(cells, object(c), {0, 0}, 0));
  }
  return twins;
}

struct Time {
  double dt;
  std::array<double, 4> pose;
};
// Presses, drags, holds and comes back.
const Time path[] = {{0.1, {0.06, 0, 0, 0}},        {0.1, {0.12, 0, 0, 0}},        {0.05, {0.12, 0.03, 0.01, 0.01}},
                     {0, {0.12, 0.05, 0.01, 0.02}}, {2, {0.12, 0.05, 0.01, 0.02}}, {0.1, {0.08, 0.05, 0.04, 0.02}},
                     {1e6, {0.08, 0.02, 0.04, 0}}};

template <class Real>
void expect_twin(double tolerance, double close) {
  PadStepper<Real> steps(executor(), gel(), count, std::array{0.5}, options_of(tolerance));
  put(steps);
  std::vector<fem::SteppedContact> twins = twins_on(steps.cells(), 1e-9);
  for (const auto& [dt, pose] : path) {
    steps.set_dt(dt);
    std::vector<double> poses;
    for (std::size_t c = 0; c < count; ++c) poses.insert(poses.end(), pose.begin(), pose.end());
    steps.move(poses);
    for (std::size_t c = 0; c < count; ++c) {
      twins[c].dt = dt;
      const fem::SteppedState s = twins[c].move(pose[0], {pose[1], pose[2], pose[3]});
      const double P = s.force[0];
      EXPECT_NEAR(number(steps, c, STEP_RESULT_P), P, close * P) << c << " " << dt;
      for (int k = 1; k < 4; ++k)
        EXPECT_NEAR(number(steps, c, STEP_RESULT_P + k), s.force[k], close * P) << c << " " << dt << " " << k;
      // Four rounds of the margin leave 1e-3.
      EXPECT_NEAR(number(steps, c, STEP_RESULT_S), s.slip_index, 1e-3 + 10 * close) << c << " " << dt;
    }
  }
}

TEST(PadStepCreep, AgreesWithItsTwin) { expect_twin<double>(1e-9, 2e-7); }
TEST(PadStepCreep, AgreesWithItsTwinInSinglePrecision) { expect_twin<float>(1e-3, 2e-3); }

// By wrench: a hold sinks, and its grip by force stays.
TEST(PadStepCreep, MeetsWrenches) {
  PadStepper<double> steps(executor(), gel(), count, std::array{0.5}, options_of(1e-9));
  put(steps);
  std::vector<fem::SteppedContact> twins = twins_on(steps.cells(), 1e-10);
  std::array<double, count> last{};
  for (const auto& [dt, Q] : {std::pair{0.0, 0.0}, {0.1, 0.1}, {1.0, 0.1}, {10.0, 0.1}}) {
    const double P = 0.5;
    steps.set_dt(dt);
    std::vector<double> wrench;
    for (std::size_t c = 0; c < count; ++c) wrench.insert(wrench.end(), {P, Q, 0.2 * Q, 0});
    steps.press(wrench);
    for (std::size_t c = 0; c < count; ++c) {
      twins[c].dt = dt;
      const fem::SteppedState s = twins[c].press({P, Q, 0.2 * Q, 0}, 1e-7);
      EXPECT_TRUE(s.met) << c;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_P), P, 1e-6) << c << " " << dt;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_QX), Q, 1e-6) << c << " " << dt;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_DEPTH), twins[c].depth(), 1e-5 * twins[c].depth()) << c << " " << dt;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_X), twins[c].motion()[0], 1e-5 * twins[c].depth()) << c << " " << dt;
      EXPECT_GT(number(steps, c, STEP_RESULT_DEPTH), last[c]);
      last[c] = number(steps, c, STEP_RESULT_DEPTH);
    }
  }
}

// Thousands of short steps: what fp32 rounds does not add up.
TEST(PadStepCreep, HoldsForThousandsOfShortSteps) {
  const auto held = [](auto real) {
    PadStepper<decltype(real)> steps(executor(), gel(), 1, std::array{0.5}, {.cells = 8, .cell = 0.35, .dt = 3e-3});
    steps.set_surface(0, fem::pad_surface(steps.cells(), object(0), {0, 0}, 0));
    for (int k = 0; k < 1500; ++k) steps.move(std::array{0.12, k < 10 ? 0.003 * k : 0.03, 0.0, 0.0});
    return std::array{number(steps, 0, STEP_RESULT_P), number(steps, 0, STEP_RESULT_QX)};
  };
  const auto [P, Q] = held(0.0);
  const auto [P32, Q32] = held(0.0f);
  EXPECT_NEAR(P32, P, 2e-4 * P);
  EXPECT_NEAR(Q32, Q, 5e-4 * P);  // of a step's sweeps
}

// A state has all that rubber remembers: another stepper goes on with the same bits, whatever lies beside it.
TEST(PadStepCreep, StatesGoOnWithTheSameBits) {
  PadStepper<float> steps(executor(), gel(), count, std::array{0.5}, options_of(1e-3));
  PadStepper<float> alone(executor(), gel(), 1, std::array{0.5}, options_of(1e-3));
  put(steps);
  alone.set_surface(0, fem::pad_surface(steps.cells(), object(1), {0, 0}, 0));
  const auto move = [](PadStepper<float>& of, const Time& time) {
    of.set_dt(time.dt);
    std::vector<double> poses;
    for (std::size_t c = 0; c < of.count(); ++c) poses.insert(poses.end(), time.pose.begin(), time.pose.end());
    of.move(poses);
  };
  for (int k = 0; k < 4; ++k) move(steps, path[k]);
  const std::size_t second = 1;
  alone.set_state(steps.state(std::span(&second, 1)));
  for (int k = 4; k < 7; ++k) {
    move(steps, path[k]), move(alone, path[k]);
    EXPECT_EQ(rows_of(steps, 1), rows_of(alone, 0)) << k;
  }
  const auto kept = steps.keep();
  move(steps, path[2]);
  const auto first = rows_of(steps, 0);
  steps.put_back(kept);
  move(steps, path[2]);
  EXPECT_EQ(rows_of(steps, 0), first);
  steps.reset(std::vector<std::uint8_t>{0, 1, 0});
  alone.reset();
  move(steps, path[1]), move(alone, path[1]);
  EXPECT_EQ(rows_of(steps, 1), rows_of(alone, 0));
}

TEST(PadStepCreep, RefusesStatesOfOtherRubberAndTimesThatAreNone) {
  PadStepper<float> creeping(executor(), gel(), 1, std::array{0.5}, options_of(1e-3));
  PadStepper<float> elastic(executor(), rubber, 1, std::array{0.5}, options_of(1e-3));
  fem::PadSensor other = gel();
  other.relaxation[0][1] = 0.5;
  PadStepper<float> slower(executor(), other, 1, std::array{0.5}, options_of(1e-3));
  EXPECT_THROW(creeping.set_state(elastic.state()), ValueError);
  EXPECT_THROW(creeping.set_state(slower.state()), ValueError);
  EXPECT_THROW(elastic.set_state(creeping.state()), ValueError);
  for (const double dt : {-1.0, std::nan(""), 1e13}) EXPECT_THROW(creeping.set_dt(dt), ValueError);
}

// A pose, a cover and a height that are none leave tractions as they are, and so what they do to all cells, near and
// far.
TEST(PadStepCreep, NumbersThatAreNoInputChangeNothingThatTractionsDo) {
  PadStepper<double> steps(executor(), gel(), 1, std::array{0.5}, options_of(1e-9));
  const fem::PadSurface ball = fem::pad_surface(steps.cells(), object(1), {0, 0}, 0);
  const std::array pose{0.12, 0.02, 0.0, 0.0};
  steps.set_surface(0, ball);
  steps.set_dt(0.2);
  steps.move(std::array{0.12, 0.0, 0.0, 0.0});
  steps.move(pose);
  const std::size_t cells = 120, w = steps.state_rows() - 9 * cells;
  const auto remembered = [&] {
    const std::vector<double> all = steps.state();
    return std::vector(&all[w], &all[w] + 3 * cells);
  };
  const std::vector<double> before = remembered(), tractions = steps.tractions();
  EXPECT_GT(std::ranges::max(before), 0.01);
  const auto expect_same = [&](const char* what, double depth, const fem::PadSurface& surface) {
    steps.set_surface(0, surface);
    steps.move(std::array{depth, 0.02, 0.0, 0.0});
    EXPECT_TRUE(static_cast<int>(number(steps, 0, STEP_RESULT_FLAGS)) & STEP_INVALID) << what;
    EXPECT_EQ(steps.tractions(), tractions) << what;
    EXPECT_EQ(remembered(), before) << what;
  };
  fem::PadSurface cover = ball, height = ball;
  cover.cover[60] = height.height[60] = std::nan("");
  expect_same("pose", std::nan(""), ball);
  expect_same("cover", 0.12, cover);
  expect_same("height", 0.12, height);
  steps.set_surface(0, ball);
  steps.move(pose);
  EXPECT_EQ(static_cast<int>(number(steps, 0, STEP_RESULT_FLAGS)), 0);
  EXPECT_LT(number(steps, 0, STEP_RESULT_RESIDUAL), 1e-5);
}

// Markers of the surface go with a ball that they stick to, however its force falls. Cells are 0.2 mm.
TEST(PadStepCreep, MarkersGoWithTheObjectThatTheyStickTo) {
  StepOptions options{.cells = 16, .cell = 0.2};
  options.markers = Markers{.depth = 0, .places = {{0, 0}, {0.2, 0.2}}};
  PadStepper<double> steps(executor(), gel(), 1, std::array{50.0}, options);
  steps.set_surface(0, fem::pad_surface(steps.cells(), {.shape = fem::Sphere{8}}, {0, 0}, 0));
  double first = 0;
  for (const auto& [dt, way] : {std::pair{0.1, 0.0}, {0.1, 1.0}, {1.0, 1.0}, {30.0, 1.0}}) {
    steps.set_dt(dt);
    steps.move(std::array{0.25, 0.05 * way, 0.02 * way, 0.0});
    if (first == 0) first = number(steps, 0, STEP_RESULT_P);
    const auto u = steps.markers();
    for (const std::size_t m : {0u, 1u}) {
      EXPECT_NEAR(u[3 * m], 0.05 * way, 1e-3) << dt;
      EXPECT_NEAR(u[3 * m + 1], 0.02 * way, 1e-3) << dt;
      EXPECT_NEAR(u[3 * m + 2], -0.25 + 0.005 * static_cast<double>(m), 2e-3) << dt;
    }
  }
  EXPECT_LT(number(steps, 0, STEP_RESULT_P), 0.8 * first);
  // A state goes on in another stepper; without markers it is another one.
  PadStepper<double> other(executor(), gel(), 1, std::array{50.0}, options);
  other.set_state(steps.state());
  EXPECT_EQ(other.markers()[2], steps.markers()[2]);
  options.markers.reset();
  PadStepper<double> plain(executor(), gel(), 1, std::array{50.0}, options);
  EXPECT_THROW(plain.set_state(steps.state()), ValueError);
}

}  // namespace tactel::host::pad_step_creep_test
