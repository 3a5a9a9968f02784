// SPDX-License-Identifier: Apache-2.0

// Pads with free sides through files, solve(), streams and JSON.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/answers/answer_forms.h"
#include "host/answers/solve.h"
#include "host/answers/warnings.h"
#include "host/contact/pads/pad_stream.h"
#include "host/scenes/scene_json.h"
#include "host/support/errors.h"
#include "kernels/shared/contact_layout.h"
#include "tests/host/device/test_device.h"
#include "tests/thrown_message.h"

namespace tactel::host::free_sides_solve_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

/// A ball over the edge of a square pad.
fem::PadScene over_the_edge() {
  fem::PadScene scene;
  scene.sensor = {.thickness = 4.5, .young = 1, .poisson = 0.48, .length = 19, .width = 19};
  scene.indenter = {.shape = fem::Sphere{15}, .position = {8.5, 0.2}};
  scene.load.indentation = {0.6};
  scene.load.drags = {{0.1, 0.05, 0.01}, {0.2, 0.05, 0.05}};
  return scene;
}

TEST(FreeSidesSolve, AnswersByTheKernelOnAllRungs) {
  const fem::PadScene scene = over_the_edge();
  const PadOutcome twelve = solve(scene, {}), eight = solve(scene, {.rung = "pad-8"});
  const PadOutcome reference = solve(scene, {.rung = "reference"});
  for (const PadOutcome* of : {&twelve, &eight}) {
    EXPECT_EQ(of->solver, "batched");
    EXPECT_NE(of->device, "host");
    EXPECT_FALSE(of->solution.fell_back);
    ASSERT_TRUE(of->error);
    for (std::size_t k = 0; k < of->solution.steps.size(); ++k) {
      const fem::PadStep &step = of->solution.steps[k], &exact = reference.solution.steps[k];
      EXPECT_TRUE(step.converged);
      // Stated errors hold beside the reference, whose own is stated too.
      EXPECT_NEAR(step.P, exact.P, (of->error->expected.P + reference.error->expected.P) * exact.P);
      EXPECT_NEAR(*step.slip_index, *exact.slip_index, of->error->expected.S + reference.error->expected.S);
    }
    EXPECT_THAT(warnings(*of), Not(Contains(HasSubstr("edge"))));
  }
  // Rubber flees outward over the edge: the ball pulls inwards, and has S before any drag (an independent program has
  // 0.22 for a ball at 6.5 mm).
  EXPECT_LT(twelve.solution.steps[0].Q[0], -0.05 * twelve.solution.steps[0].P);
  EXPECT_GT(*twelve.solution.steps[0].slip_index, 0.1);
}

TEST(FreeSidesSolve, StatedErrorsOfACubeAreNoLessThanMadeAndStressIsSaidUsefully) {
  // A face over a cube, nu 0.3, mu 0.4, pressed by 0.5 %, where strain adds little; P by finite elements of
  // another program, in proportion from 5 %.
  fem::PadScene scene;
  scene.sensor = {.thickness = 8, .young = 1, .poisson = 0.3, .length = 8, .width = 8};
  scene.sensor.pitch = {2.32, 2.32};
  scene.indenter.shape = fem::Box{.half_widths = {40, 40}};
  scene.friction = 0.4;
  scene.load.indentation = {0.04};
  const PadOutcome answer = solve(scene, {.rung = "pad-12"});
  ASSERT_TRUE(answer.error);
  EXPECT_NEAR(answer.solution.steps[0].P, 0.3411769, answer.error->expected.P * 0.3411769);
  EXPECT_LT(answer.error->expected.P, 0.03);
  EXPECT_LT(answer.error->expected.sigma, 0.2);
  EXPECT_LT(answer.error->expected.tau, 0.2);
}

TEST(FreeSidesSolve, HeldSidesAreTheEndlessLayerAndRefuseEdges) {
  fem::PadScene scene = over_the_edge();
  scene.sensor.sides = fem::Sides::held;
  EXPECT_THAT(thrown_message<ValueError>([&] { solve(scene, {.precision = "fp32"}); }),
              HasSubstr("the model has no free sides"));
  scene.indenter.position = {0, 0};
  scene.sensor.length = scene.sensor.width = 40;
  const double held = solve(scene, {.precision = "fp32"}).solution.steps[0].P;
  scene.sensor.length.reset(), scene.sensor.width.reset(), scene.sensor.sides = fem::Sides::free;
  EXPECT_EQ(solve(scene, {.precision = "fp32"}).solution.steps[0].P, held);  // not given: as before
}

// The kernel and the twin share the algorithm: what their tolerances leave, of S also the rounds of its margin.
TEST(FreeSidesSolve, TakesDeviceAndPrecisionAsHeldPadsDo) {
  const fem::PadScene scene = over_the_edge();
  EXPECT_THAT(thrown_message<ConfigError>([&] { solve(scene, {.device = "nosuchdevice"}); }),
              HasSubstr("nosuchdevice"));
  const PadOutcome twin = solve(scene, {.rung = "pad-8", .solver = "twin"});
  EXPECT_EQ(twin.solver, "twin");
  EXPECT_EQ(twin.device, "host");
  for (const auto& [precision, off] : {std::pair{"fp32", 5e-4}, {"fp64", 1e-6}}) {
    const PadOutcome kernel = solve(scene, {.rung = "pad-8", .precision = precision});
    EXPECT_EQ(kernel.precision, precision);
    for (std::size_t k = 0; k < twin.solution.steps.size(); ++k) {
      const fem::PadStep &p = kernel.solution.steps[k], &q = twin.solution.steps[k];
      EXPECT_NEAR(p.P / q.P, 1, off);
      EXPECT_LT((p.Q - q.Q).norm(), 4 * off * scene.friction * q.P);
      EXPECT_NEAR(*p.slip_index, *q.slip_index, 1.5e-3);
    }
  }
}

TEST(FreeSidesSolve, RefusesWhatItDoesNotBear) {
  fem::PadScene wide = over_the_edge();  // over 60 mm of a pad that is 80 mm long, 18 H
  wide.sensor.length = 80, wide.indenter = {.shape = fem::Box{{30, 4}, 0}};
  wide.load = {.indentation = {0.1}};
  EXPECT_THAT(thrown_message<ValueError>([&] { solve(wide, {}); }),
              AllOf(HasSubstr("sensor.sides"), HasSubstr("\"held\" here")));
}

TEST(FreeSidesSolve, StreamsAnswerAsSolveDoes) {
  // A mix of free and held sides, one by one and without their forces.
  std::vector<fem::PadScene> scenes(4, over_the_edge());
  scenes[1].indenter.position = {0, 0}, scenes[1].sensor.length.reset();
  scenes[2].indenter = {.shape = fem::Box{{20, 20}, 0}, .yaw = 30};
  scenes[2].load.indentation = {0.1}, scenes[2].load.drags.clear();
  const PadStream stream(executor(), model_of(usual_pad_rung()));
  const std::vector<fem::PadSolution> all = stream.solve(scenes);
  std::vector<double> P(scenes.size(), -1);
  ASSERT_TRUE(stream.solve(
      scenes, [&](std::size_t i, const LaneAnswer& answer, PadStream::Alone&&) { P[i] = answer.result(0, RESULT_P); },
      [&](std::size_t i, fem::PadSolution&& solution) { P[i] = solution.steps[0].P; },
      [](std::size_t) { return true; }));
  for (const std::size_t i : {0u, 2u, 3u}) {
    const fem::PadSolution one = solve(scenes[i], {}).solution;
    for (std::size_t k = 0; k < one.steps.size(); ++k) {
      EXPECT_NEAR(all[i].steps[k].P, one.steps[k].P, 3e-4 * one.steps[k].P);  // the kernel in fp32 beside the host
      EXPECT_NEAR(*all[i].steps[k].slip_index, *one.steps[k].slip_index, 1.5e-3);
    }
    EXPECT_EQ(P[i], all[i].steps[0].P);
  }
  EXPECT_GT(P[1], 0);
}

TEST(FreeSidesSolve, JsonSaysWhichSides) {
  fem::PadScene scene = over_the_edge();
  EXPECT_EQ(to_json(scene)["sensor"]["sides"], "free");
  scene.sensor.sides = fem::Sides::held;
  EXPECT_EQ(to_json(scene)["sensor"]["sides"], "held");
  scene.sensor.width.reset();
  EXPECT_FALSE(to_json(scene)["sensor"].contains("sides"));
}

}  // namespace tactel::host::free_sides_solve_test
