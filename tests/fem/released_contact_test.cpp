// SPDX-License-Identifier: Apache-2.0

// What is left of a contact that does not press any more, and friction without limit.
#include <gtest/gtest.h>

#include <limits>

#include "fem/gap/gap_condensed.h"
#include "fem/gap/gap_reference.h"
#include "fem/gap/gap_sweep.h"

namespace tactel::fem::released_contact_test {

constexpr double bonded = std::numeric_limits<double>::infinity();

/// Every solver of this folder.
std::vector<ContactSolution> solve_by_all(const Scene& scene) {
  const Condensation condensation = condense(scene.sensor);
  return {solve_gap_reference(scene), GapCondensed(condensation).solve(scene),
          GapSweep<double>(condensation).solve(scene)};
}

Scene pressed(const Shape& shape, double mu) { return {"", {}, {shape, 0.0}, mu, {}}; }

/// Pressed, released, dragged at depth 0, and pressed again: between the presses there is nothing, not a trace of force
/// that gives an S, nor rubber wedged under an indenter that does not press.
TEST(ReleasedContact, BearsNothingAndForgetsFriction) {
  for (const double mu : {0.0, 0.5, 1.0, bonded}) {
    Scene scene = pressed(Flat{}, mu);
    scene.load.indentation = {0.15, 0.0};
    scene.load.tangential = {0.1, 0.4};
    for (const ContactSolution& solution : solve_by_all(scene)) {
      ASSERT_EQ(solution.steps.size(), 4u);
      for (std::size_t k = 1; k < 4; ++k) {
        const ContactStep& step = solution.steps[k];
        EXPECT_TRUE(step.converged) << "mu " << mu << ", step " << k;
        EXPECT_EQ(step.P, 0) << "mu " << mu << ", step " << k;
        EXPECT_EQ(step.Q, 0) << "mu " << mu << ", step " << k;
        EXPECT_FALSE(step.slip_index) << "mu " << mu << ", step " << k;
        EXPECT_EQ(std::ranges::count(step.status, GapStatus::open), 41) << "mu " << mu << ", step " << k;
        EXPECT_EQ(step.slip_distance, 0);
      }
    }
    scene.load.tangential.clear();
    scene.load.indentation = {0.15, 0.0, 0.15};
    for (const ContactSolution& solution : solve_by_all(scene)) {
      EXPECT_TRUE(solution.steps[2].converged) << "mu " << mu;
      EXPECT_NEAR(solution.steps[2].P, solution.steps[0].P, 1e-9 * solution.steps[0].P) << "mu " << mu;
    }
  }
}

/// One node under the point of a wedge, in the middle: without friction it does not move along x, and all of the drag
/// is slip; glued to the indenter it moves as far as that does, and none is.
TEST(SlipDistance, IsTheDragThatTheRubberDoesNotFollow) {
  Scene scene = pressed(Wedge{20}, 0.0);
  scene.load.tangential = {0.2, -0.3};
  for (const ContactSolution& solution : solve_by_all(scene)) {
    EXPECT_NEAR(solution.steps[0].slip_distance, 0, 1e-12);
    EXPECT_NEAR(solution.steps[1].slip_distance, 0.2, 1e-12);
    EXPECT_NEAR(solution.steps[2].slip_distance, 0.3, 1e-12);
  }
  scene.friction = 100;
  scene.load.tangential = {0.02};
  for (const ContactSolution& solution : solve_by_all(scene)) EXPECT_NEAR(solution.steps[1].slip_distance, 0, 1e-9);
}

TEST(Bonded, HasNoSlippageIndexButZero) {
  Scene scene = pressed(Parabola{10}, bonded);
  scene.load.tangential = {0.05};
  for (const ContactSolution& solution : solve_by_all(scene))
    for (const ContactStep& step : solution.steps) {
      EXPECT_TRUE(step.converged);
      EXPECT_GT(step.P, 0);
      EXPECT_EQ(step.slip_index, 0);
    }
}

/// A narrow Taylor shape turns the rubber over: a bonded node is about to lift off while friction still pulls it, which
/// is the limit of large mu. P and Q depend on mu as 1 / mu there, so mu = 1e4 is within 1e-3 of it.
TEST(Bonded, IsTheLimitOfLargeFriction) {
  Scene scene = pressed(Taylor{{1, 2, 4}, 0.0028885164, 0.00073159020}, bonded);
  scene.sensor.length = 0.01, scene.sensor.thickness = 0.0032636289, scene.sensor.young = 0.345;
  scene.indenter.position = 0.005;
  scene.load.indentation = {0.00027977995};
  scene.load.tangential = {0.00022846617, 0.00041215973, 0.00030098947, 0.00026554860, 0.00023543376, 0.00046190660};
  const Condensation condensation = condense(scene.sensor);
  const ContactSolution limit = GapCondensed(condensation).solve(scene), whole = solve_gap_reference(scene);
  scene.friction = 1e4;
  const ContactSolution large = GapCondensed(condensation).solve(scene);
  for (std::size_t k = 0; k < limit.steps.size(); ++k) {
    EXPECT_TRUE(limit.steps[k].converged && whole.steps[k].converged && large.steps[k].converged) << k;
    EXPECT_NEAR(limit.steps[k].P, whole.steps[k].P, 1e-10 * whole.steps[k].P) << k;
    EXPECT_NEAR(limit.steps[k].P, large.steps[k].P, 1e-3 * large.steps[k].P) << k;
    for (Eigen::Index i = 0; i < limit.steps[k].normal_force.size(); ++i) {
      const bool slips = limit.steps[k].status[i] == GapStatus::slip;
      EXPECT_TRUE(!slips || limit.steps[k].normal_force[i] > 0) << "step " << k << ", node " << i;
    }
  }
}

TEST(LostForce, IsWhatDoesNotArriveAtTheBase) {
  Condensation condensation;  // two base nodes, one surface node: a tenth of the force along x does not arrive
  condensation.base_force.resize(4, 2);
  condensation.base_force << 0.5, 0, 0, 0.5, 0.4, 0, 0, 0.5;
  EXPECT_DOUBLE_EQ(lost_force(condensation), 0.1);
}

}  // namespace tactel::fem::released_contact_test
