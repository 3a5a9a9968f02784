// SPDX-License-Identifier: Apache-2.0

// Contacts that elements of a fixed number resolve badly: the error that an answer says covers the error that it makes.
// The true numbers are those of 240 elements, 0.15 to 0.29 thicknesses wide, with constant pressures and 20 increments.
#include <gtest/gtest.h>

#include <cmath>

#include "host/answers/solve.h"
#include "host/answers/warnings.h"
#include "host/contact/lines/contact_fallback.h"

namespace tactel::host::thin_rubber_test {

struct Case {
  std::string name;
  fem::Scene scene;
  std::vector<double> S;  ///< [steps]
  double P = 0;           ///< N/mm, of the first step
};

fem::Scene on_thin_rubber(double length, double thickness, double poisson, double span) {
  return {.sensor = {.length = length,
                     .thickness = thickness,
                     .young = 1.5,
                     .poisson = poisson,
                     .tactels = 21,
                     .tactel_span = span},
          .friction = 0.3,
          .model = fem::SurfaceModel::patch};
}

Case incompressible() {
  Case c{"thin, nu 0.5", on_thin_rubber(60, 0.5, 0.5, 50), {0, 0.0124, 0.0839, 1, 1}, 803.3};
  c.scene.indenter.shape = fem::Parabola{2000};
  c.scene.load.indentation = {0.02};
  c.scene.load.tangential = {0.1, 0.5, 1.5, 4.0};
  return c;
}

Case nu_0499() {
  Case c{"thin, nu 0.499", on_thin_rubber(60, 1, 0.499, 50), {0, 0.0519, 0.1652, 0.7264}, 80.72};
  c.scene.indenter.shape = fem::Parabola{800};
  c.scene.load.indentation = {0.05};
  c.scene.load.tangential = {0.1, 0.3, 0.8};
  return c;
}

Case nu_0495() {
  Case c{"thin, nu 0.495", on_thin_rubber(40, 1.5, 0.495, 38), {0, 0.0088, 0.0262}, 33.0};
  c.scene.indenter.shape = fem::Parabola{500};
  c.scene.load.indentation = {0.1};
  c.scene.load.tangential = {0.01, 0.03};
  return c;
}

/// The contact slips to both sides while it is pressed: S is the small difference of two halves.
Case small_friction() {
  Case c{"mu 0.041", {}, {-0.0311, -0.0433, -0.2959, 0.5041, 0.3362, 0.7733, 1}, 0.020094};
  c.scene.model = fem::SurfaceModel::patch;
  c.scene.sensor.length = 4.623, c.scene.sensor.thickness = 0.67;
  c.scene.sensor.young = 0.311, c.scene.sensor.poisson = 0.3532271138194929;
  c.scene.sensor.tactels = 33, c.scene.sensor.tactel_span = 4.161;
  const fem::Profile profile{.x = {-2.2938347523673586, -1.3487574755594087, 0.34160313816483356, 0.42631835453406486,
                                   0.5211449700054643, 0.9803257030256813, 1.2015053180518263, 1.7313533960088718},
                             .y = {1.0032414744884919, 0.6028259377899231, 0.01269692279932122, 0.00381963338525082,
                                   0.0, 0.01486220032736052, 0.026034253000829843, 0.15025278784544127}};
  c.scene.indenter.shape = profile;
  c.scene.indenter.position = -0.3647431678927098;
  c.scene.friction = 0.040976523763826295;
  c.scene.load.indentation.clear();
  c.scene.load.normal_force = {0.040187157618946874};
  c.scene.load.indentation_steps = 2;
  c.scene.load.tangential = {-0.001293, 0.002734, 0.001927, 0.004245, 0.008253};
  return c;
}

double error_of_S(const Case& c, const fem::ContactSolution& answer) {
  double most = 0;
  EXPECT_EQ(answer.steps.size(), c.S.size());
  for (std::size_t k = 0; k < c.S.size(); ++k) most = std::max(most, std::abs(*answer.steps[k].slip_index - c.S[k]));
  return most;
}

constexpr double of_truth = 0.001;  // 120 and 240 elements differ by this at most

class SaidAndMade : public testing::TestWithParam<Case (*)()> {};

TEST_P(SaidAndMade, ByTheDefaultAndEveryRung) {
  const Case c = GetParam()();
  for (const char* rung : {"", "patch-8", "patch-12", "patch-16", "patch-24"}) {
    const SolveOutcome outcome = solve(c.scene, {.rung = rung});
    ASSERT_TRUE(every_step_converged(outcome.solution)) << c.name << ' ' << rung;
    const auto said = mesh_error(outcome);
    ASSERT_TRUE(said) << c.name << ' ' << rung;
    EXPECT_LE(error_of_S(c, outcome.solution), said->expected.S + of_truth) << c.name << ' ' << rung;
    EXPECT_NEAR(outcome.solution.steps[0].P, c.P, (said->expected.P + 0.01) * c.P) << c.name << ' ' << rung;
  }
}

TEST_P(SaidAndMade, ByThePlanner) {
  const Case c = GetParam()();
  for (const double accuracy : {0.05, 0.02, 0.01}) {
    const SolveOutcome outcome = solve(c.scene, {.accuracy = accuracy});
    ASSERT_TRUE(outcome.plan);
    const double made = error_of_S(c, outcome.solution), said = mesh_error(outcome)->expected.S;
    EXPECT_LE(made, said + of_truth) << c.name << ' ' << accuracy << ' ' << outcome.plan->why();
    EXPECT_GE(said, outcome.plan->trials.back().difference.S);
    EXPECT_EQ(outcome.plan->kept, said <= accuracy);
  }
}

INSTANTIATE_TEST_SUITE_P(Hard, SaidAndMade, testing::Values(incompressible, nu_0499, nu_0495, small_friction));

/// 12 and 24 elements happen to agree in P. The true P is that of the reference, 120 elements.
TEST(ThinRubber, ThePOfWideElementsIsCoveredByItsError) {
  fem::Scene scene = on_thin_rubber(12, 0.146135, 0.49, 10);
  scene.sensor.young = 2, scene.friction = 0.5082;
  scene.indenter.shape = fem::Parabola{528.5};
  scene.load.indentation = {0.016245};
  scene.load.tangential = {0.00412746, 0.0123824};
  const double P = solve(scene, {.rung = "reference"}).solution.steps[0].P;
  for (const char* rung : {"patch-8", "patch-12", "patch-16", "patch-24"}) {
    const SolveOutcome outcome = solve(scene, {.rung = rung});
    const auto said = mesh_error(outcome);
    ASSERT_TRUE(said);
    EXPECT_NEAR(outcome.solution.steps[0].P, P, said->expected.P * P) << rung;
  }
}

/// With elements of constant pressure the default had 272 N/mm and an S of 0.172.
TEST(ThinRubber, TheDefaultIsNear) {
  const Case c = incompressible();
  const SolveOutcome outcome = solve(c.scene, {});
  EXPECT_TRUE(outcome.solution.linear_elements);
  EXPECT_NEAR(outcome.solution.steps[0].P, c.P, 0.1 * c.P);  // 8 of the 24 elements stay open
  EXPECT_LE(error_of_S(c, outcome.solution), 0.01);
  EXPECT_EQ(model_name(outcome).rfind("patch of 24 linear elements", 0), 0u) << model_name(outcome);
}

TEST(ThinRubber, WhatIsNotEstimatedIsSaid) {
  fem::Scene scene;
  scene.load.indentation = {0.1}, scene.load.tangential_step = 0.001, scene.load.tangential_steps = 100;
  const SolveOutcome outcome = solve(scene, {.estimate_error = true});
  EXPECT_FALSE(outcome.error);
  EXPECT_EQ(warnings(outcome).back(), "the error of this answer is not estimated: it has more than 100 load steps");
}

}  // namespace tactel::host::thin_rubber_test
