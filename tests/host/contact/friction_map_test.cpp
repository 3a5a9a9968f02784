// SPDX-License-Identifier: Apache-2.0

// Friction that differs from cell to cell: the kernels beside their twins, the bits of one mu, and states of steppers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_step.h"
#include "host/contact/pads/pad_contact.h"
#include "host/contact/pads/pad_stream.h"
#include "tests/fem/expect_error.h"
#include "tests/host/contact/pad_launch.h"
#include "tests/host/contact/stepped.h"

namespace tactel::host::friction_map_test {

const FrictionMap blotched{{{0.7, 0.2, 0.5}, {0.1, 0.6, 0.0}, {0.4, 0.3, 0.9}}, 0.7};

std::vector<fem::PadScene> mix(const fem::PadSensor& sensor, std::size_t count) {
  fem::PadMix draw(5, &sensor);
  std::vector<fem::PadScene> scenes(count);
  for (fem::PadScene& scene : scenes) scene = draw();
  return scenes;
}

void expect_same(const fem::PadSolution& a, const fem::PadSolution& b, std::size_t i) {
  ASSERT_EQ(a.steps.size(), b.steps.size());
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    const fem::PadStep &p = a.steps[k], &q = b.steps[k];
    EXPECT_EQ(p.normal_force, q.normal_force) << i << " " << k;
    EXPECT_EQ(p.tangential_force, q.tangential_force) << i << " " << k;
    EXPECT_EQ(p.stress, q.stress) << i << " " << k;
    EXPECT_EQ(p.slip_index, q.slip_index) << i << " " << k;
    EXPECT_EQ(p.status, q.status) << i << " " << k;
  }
}

template <class Real>
void expect_twin(const fem::PadSensor& sensor, std::size_t count, double tolerance, double close) {
  std::vector<fem::PadScene> scenes = mix(sensor, count);
  for (fem::PadScene& scene : scenes) scene.set_friction(blotched);
  const auto batch = ran<Real>(scenes, tolerance);
  const fem::PadLayer layer = fem::pad_layer(sensor.poisson);
  const fem::PadSolver twin(layer, {.cells = 8, .tolerance = std::min(1e-7, tolerance)});
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution a = batch.solution(i), b = twin.solve_on(batch.cells(i), batch.scene(i));
    for (std::size_t k = 0; k < b.steps.size(); ++k) {
      const fem::PadStep &p = a.steps[k], &q = b.steps[k];
      EXPECT_TRUE(p.converged) << i << " " << k << " " << p.residual.largest();
      EXPECT_NEAR(p.P, q.P, close * q.P) << i << " " << k;
      EXPECT_LE((p.Q - q.Q).norm(), close * q.P) << i << " " << k;
      EXPECT_NEAR(p.mu, q.mu, close) << i << " " << k;
      // Four rounds of the margin leave 1e-3.
      EXPECT_NEAR(p.slip_index.value_or(0), q.slip_index.value_or(0), 1e-3 + 10 * close) << i << " " << k;
    }
  }
}

TEST(PadFrictionMap, AgreesWithItsTwin) { expect_twin<double>(rubber, 12, 1e-10, 1e-7); }
TEST(PadFrictionMap, AgreesWithItsTwinInSinglePrecision) { expect_twin<float>(rubber, 40, 1e-3, 2e-3); }

fem::PadSensor block() {
  fem::PadSensor sensor = rubber;
  sensor.length = 8, sensor.width = 8;
  return sensor;
}
TEST(PadFrictionMap, AgreesWithItsTwinWhereSidesAreFree) { expect_twin<double>(block(), 3, 1e-9, 1e-6); }

// One mu in a map, also beside scenes with maps of their own, and scenes without beside them.
TEST(PadFrictionMap, OneMuHasTheBitsOfANumber) {
  for (const bool free : {false, true}) {
    std::vector<fem::PadScene> scenes = mix(free ? block() : rubber, free ? 3 : 24);
    const auto alone = ran<float>(scenes, 1e-3);
    std::vector<fem::PadScene> mapped = scenes;
    for (std::size_t i = 0; i < mapped.size(); ++i)
      if (i % 3 < 2) mapped[i].set_friction(i % 3 == 0 ? FrictionMap{{{scenes[i].friction}}, 1} : blotched);
    const auto batch = ran<float>(mapped, 1e-3);
    for (std::size_t i = 0; i < scenes.size(); ++i)
      if (i % 3 != 1) expect_same(batch.solution(i), alone.solution(i), i);
  }
}

// Answers in place, as of many paths, say the mean mu that solutions have from their forces.
TEST(PadFrictionMap, AnswersInPlaceHaveTheMeanFriction) {
  std::vector<fem::PadScene> scenes = mix(rubber, 20);
  for (std::size_t i = 0; i < scenes.size(); i += 2) scenes[i].set_friction(blotched);
  const auto batch = ran<double>(scenes, 1e-3);
  const LaneView<double> view(batch);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution solution = batch.solution(i);
    for (int k = 0; k < view.answer(i).steps; ++k)
      EXPECT_NEAR(view.answer(i).result(k, PAD_RESULT_MU), solution.steps[static_cast<std::size_t>(k)].mu, 1e-12);
  }
}

// ---- steps

constexpr std::size_t count = 5;
const StepOptions fine{
    .cells = {10, 12}, .cell = {0.28, 0.25}, .tolerance = 1e-9, .force_tolerance = 1e-7, .most_sweeps = 3000};

/// Another map for each contact, [count][cells].
std::vector<double> maps(const fem::PadCells& cells) {
  std::vector<double> all;
  for (std::size_t c = 0; c < count; ++c)
    for (int i = 0; i < cells.count(); ++i)
      all.push_back(0.4 +
                    0.35 * std::sin(2.0 * cells.x(i / cells.ny()) + cells.y(i % cells.ny()) + static_cast<double>(c)));
  return all;
}
template <class Real>
void put(PadStepper<Real>& steps, std::size_t contacts = count) {
  for (std::size_t c = 0; c < contacts; ++c)
    steps.set_surface(c,
                      fem::pad_surface(steps.cells(), {.shape = fem::Sphere{3.0 + static_cast<double>(c)}}, {0, 0}, 0));
}
std::vector<double> of_all(std::array<double, 4> one) {
  std::vector<double> all;
  for (std::size_t c = 0; c < count; ++c) all.insert(all.end(), one.begin(), one.end());
  return all;
}
constexpr std::array<double, 4> way[] = {{0.06, 0, 0, 0},       {0.12, 0, 0, 0},         {0.12, 0.03, 0.01, 0.01},
                                         {0.12, 0.06, 0.01, 0}, {0.1, 0.06, 0.05, 0.02}, {0.1, 0.3, 0.05, 0.02}};

template <class Real>
void expect_stepped_twin(const fem::PadSensor& pad, double tolerance, double close) {
  StepOptions options = fine;
  options.tolerance = tolerance, options.dt = 0.2;
  PadStepper<Real> steps(executor(), pad, count, std::array{0.5}, options);
  const fem::PadCells cells = steps.cells();
  const std::vector<double> mu = maps(cells);
  steps.set_friction(mu);
  put(steps);
  std::vector<fem::SteppedContact> twins;
  for (std::size_t c = 0; c < count; ++c) {
    twins.emplace_back(fem::pad_layer(rubber.poisson), pad, cells, 0.5,
                       fem::PadOptions{.cells = 12, .tolerance = 1e-9, .accept = 1e-6, .most_sweeps = 4000});
    twins.back().dt = 0.2;
    twins.back().set_friction(Eigen::Map<const Eigen::VectorXd>(&mu[c * cells.count()], cells.count()));
    twins.back().set_surface(fem::pad_surface(cells, {.shape = fem::Sphere{3.0 + static_cast<double>(c)}}, {0, 0}, 0));
  }
  for (const auto& pose : way) {
    steps.move(of_all(pose));
    for (std::size_t c = 0; c < count; ++c) {
      const fem::SteppedState s = twins[c].move(pose[0], {pose[1], pose[2], pose[3]});
      const double P = s.force[0];
      for (int k = 0; k < 4; ++k) EXPECT_NEAR(number(steps, c, STEP_RESULT_P + k), s.force[k], close * P) << c << k;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_S), s.slip_index, 1e-3 + 10 * close) << c;  // four rounds leave 1e-3
      EXPECT_EQ((static_cast<int>(number(steps, c, STEP_RESULT_FLAGS)) & STEP_SLIDES) != 0, s.slides) << c;
    }
  }
}
TEST(PadStepFrictionMap, AgreesWithItsTwin) { expect_stepped_twin<double>(rubber, 1e-9, 2e-7); }
TEST(PadStepFrictionMap, AgreesWithItsTwinInSinglePrecision) { expect_stepped_twin<float>(rubber, 1e-3, 2e-3); }
TEST(PadStepFrictionMap, AgreesWithItsTwinOnRubberThatCreeps) {
  fem::PadSensor gel = rubber;
  gel.relaxation = {{0.2, 0.4}};
  expect_stepped_twin<double>(gel, 1e-9, 2e-7);
}

// By wrench: Q below what all cells bear is met, beyond it the object slides at that.
TEST(PadStepFrictionMap, MeetsWrenchesThatItBears) {
  StepOptions options = fine;
  options.force_tolerance = 1e-5, options.most_solves = 40;
  PadStepper<double> steps(executor(), rubber, count, std::array{0.5}, options);
  const fem::PadCells cells = steps.cells();
  const std::vector<double> mu = maps(cells);
  steps.set_friction(mu);
  put(steps);
  steps.press(of_all({0.5, 0, 0, 0}));
  const double within = 0.5 * options.force_tolerance;
  const auto bears = [&](std::size_t c) {
    const std::vector<double> tractions = steps.tractions();
    double sum = 0;
    for (int i = 0; i < cells.count(); ++i)
      sum += mu[c * cells.count() + i] * tractions[3 * c * cells.count() + i] * cells.area();
    return sum;
  };
  std::vector<double> most;
  for (std::size_t c = 0; c < count; ++c) most.push_back(bears(c));
  for (const double part : {0.4, 0.7, 1.2, 1.2}) {
    std::vector<double> wrench;
    for (std::size_t c = 0; c < count; ++c) wrench.insert(wrench.end(), {0.5, part * most[c], 0, 0});
    steps.press(wrench);
    for (std::size_t c = 0; c < count; ++c) {
      const int flags = static_cast<int>(number(steps, c, STEP_RESULT_FLAGS));
      EXPECT_EQ((flags & STEP_SLIDES) != 0, part > 1) << c << " " << part;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_P), 0.5, within) << c << " " << part;
      const double Q = number(steps, c, STEP_RESULT_QX);
      if (part < 1)
        EXPECT_NEAR(Q, part * most[c], within) << c << " " << part;
      else
        EXPECT_LT(std::hypot(Q, number(steps, c, STEP_RESULT_QY)), 1.0001 * bears(c)) << c;
    }
  }
}

// What all touching cells lack: friction that lies elsewhere does not help.
TEST(PadStepFrictionMap, SlidesWhereNothingRubs) {
  PadStepper<float> steps(executor(), rubber, 1, std::array{0.5}, {.cells = 12, .cell = 0.3});
  std::vector<double> mu(static_cast<std::size_t>(steps.cells().count()));
  for (int i = 0; double& each : mu) each = std::abs(steps.cells().x(i++ / 12)) > 1.2 ? 0.8 : 0;
  steps.set_friction(mu);
  put(steps, 1);
  steps.press(std::array{0.2, 0.0, 0.0, 0.0});
  steps.press(std::array{0.2, 0.05, 0.0, 0.0});
  EXPECT_EQ(flags_of(steps, 0), STEP_SLIDES);
  EXPECT_NEAR(number(steps, 0, STEP_RESULT_P), 0.2, 1e-3);
  EXPECT_EQ(number(steps, 0, STEP_RESULT_QX), 0);
  EXPECT_EQ(number(steps, 0, STEP_RESULT_S), 0);  // as with mu = 0
}

// One mu in a map has the bits of the number, by motion and wrench; and states go from one to the other.
TEST(PadStepFrictionMap, OneMuHasTheBitsOfANumber) {
  const Bowls bowls = covering(9, 3);
  const auto cells = static_cast<std::size_t>(bowls.cells.count());
  std::vector<double> each;
  for (const double mu : bowls.friction) each.insert(each.end(), cells, mu);
  PadStepper<float> number = bowls.steps(executor()), map = bowls.steps(executor()), late = bowls.steps(executor());
  map.set_friction(each);
  const auto same = [&](const PadStepper<float>& of) {
    EXPECT_TRUE(std::ranges::equal(number.results(), of.results()));
    EXPECT_EQ(number.state(), of.state());
  };
  const std::vector<double> P = pressed(number, bowls);
  pressed(map, bowls), pressed(late, bowls);
  same(map);
  for (int k = 4; k < 12; ++k) {
    if (k == 8) late.set_friction(each);
    if (k == 10) map.set_friction(bowls.friction), late.set_state(map.state());
    for (PadStepper<float>* steps : {&number, &map, &late})
      k < 8 ? steps->move(bowls.pose(k)) : steps->press(bowls.wrench(k - 8, P, 0.8));
    same(map), same(late);
  }
  // A wrench that is met, over the same heights and friction: no sweep more of one than of the other.
  for (PadStepper<float>* steps : {&number, &map, &late}) steps->press(bowls.wrench(3, P, 0.8));
  same(map), same(late);
}

// Friction that changes in one cell that presses is no friction of before.
TEST(PadStepFrictionMap, AChangeOfOneCellCounts) {
  PadStepper<double> steps(executor(), rubber, count, std::array{0.5}, fine);
  std::vector<double> mu(count * steps.cells().count(), 0.5);
  steps.set_friction(mu);
  put(steps);
  steps.move(of_all({0.12, 0, 0, 0})), steps.move(of_all({0.12, 0.05, 0, 0}));
  const double Q = number(steps, 1, STEP_RESULT_QX), same = number(steps, 0, STEP_RESULT_QX);
  const std::size_t middle = 5 * 12 + 6;
  mu[steps.cells().count() + middle] = 0.01;
  steps.set_friction(mu);
  steps.move(of_all({0.12, 0.05, 0, 0}));
  const std::vector<double> tractions = steps.tractions();
  const double* n = &tractions[3 * steps.cells().count() + middle];
  EXPECT_NEAR(std::hypot(n[120], n[240]), 0.01 * n[0], 1e-8 * n[0]);
  EXPECT_LT(number(steps, 1, STEP_RESULT_QX), 0.998 * Q);  // its neighbours take over what they can
  EXPECT_EQ(number(steps, 0, STEP_RESULT_QX), same);
}

TEST(PadStepFrictionMap, SaysWhatIsWrong) {
  PadStepper<float> steps(executor(), rubber, 3, std::array{0.5}, {.cells = 8, .cell = 0.4});
  const auto refused = [&](const std::vector<double>& mu, const char* value, const char* allowed) {
    expect_value_error([&] { steps.set_friction(mu); }, "friction", value, allowed);
  };
  refused(std::vector<double>(64, 0.5), "64 numbers", "3 numbers");
  std::vector<double> mu(3 * 64, 0.5);
  for (const double wrong : {-0.1, 1e7, std::nan(""), std::numeric_limits<double>::infinity()})
    mu[100] = wrong, refused(mu, "", "0 to 1e6");  // of a cell of 1e20, S is 0
}

}  // namespace tactel::host::friction_map_test
