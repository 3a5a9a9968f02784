// SPDX-License-Identifier: Apache-2.0

// The error that a mesh's size leaves, as estimated, beside that from a mesh which is four or eight times as fine.
#include "host/answers/line_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "fem/gap/gap_reference.h"
#include "fem/gap/load_stepping.h"
#include "host/answers/answer_forms.h"
#include "host/answers/solve.h"
#include "host/scenes/scene_file.h"
#include "test_paths.h"

namespace tactel::host::line_error_test {

using ::testing::HasSubstr;
using ::testing::Not;

fem::Scene parabola() { return read_scene(std::string(TACTEL_SOURCE_DIR) + "/examples/parabola.toml"); }

fem::Scene on_mesh(fem::Scene scene, int columns, int rows) {
  scene.sensor.columns = columns;
  scene.sensor.rows = rows;
  return scene;
}

/// The errors of an answer by that of a finer mesh with pressing steps in `parts`; of one so fine that its own hardly
/// count, the true ones.
AnswerError true_error(const fem::Scene& scene, const fem::ContactSolution& answer, int columns, int rows,
                       int parts = 4) {
  fem::Scene fine = on_mesh(scene, columns, rows);
  fine.load.indentation_steps *= parts;
  fem::ContactSolution truth = fem::solve_gap_reference(fine);
  fem::keep_own_steps(truth, scene.load, parts);
  std::vector<std::size_t> steps(answer.steps.size());
  std::iota(steps.begin(), steps.end(), 0);
  return answer_error(answer, steps, truth, steps);
}

// P of the example is 2.7 % off: 1.0742 N/mm where a mesh of 641 columns has 1.1039.
TEST(MeshError, OfTheExampleCoversItsTrueError) {
  const fem::Scene scene = parabola();
  const fem::ContactSolution answer = fem::solve_gap_reference(scene);
  const auto found = mesh_error(scene, answer);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->from, "81 x 21");
  const AnswerError truth = true_error(scene, answer, 321, 81);
  EXPECT_NEAR(truth.P, 0.027, 0.003);
  for (std::size_t i = 0; i < error_members.size(); ++i) {
    EXPECT_GE(found->expected.*error_members[i], truth.*error_members[i]) << error_names[i];
    EXPECT_LE(found->expected.*error_members[i], 4 * truth.*error_members[i]) << error_names[i];
  }
}

// Twice the differences from the full finer mesh; at the second nu no condensation is precise enough. Condensed and
// full answers differ by the rounding of C, 1e-12 of the forces.
TEST(MeshError, IsThatOfTheFullFinerMesh) {
  for (const double poisson : {0.45, 0.4999995}) {
    fem::Scene scene = parabola();
    scene.sensor.poisson = poisson;
    const fem::ContactSolution answer = fem::solve_gap_reference(scene);
    const auto found = mesh_error(scene, answer);
    ASSERT_TRUE(found) << poisson;
    const AnswerError difference = true_error(scene, answer, 81, 21, 2);
    for (const auto member : error_members)
      EXPECT_NEAR(found->expected.*member, 2 * difference.*member, 1e-10) << poisson;
  }
}

TEST(MeshError, OfOtherShapesCoversTheirForces) {
  for (const fem::Shape& shape :
       {fem::Shape(fem::Flat{2}), fem::Shape(fem::Wedge{160}), fem::Shape(fem::Cylinder{8})}) {
    fem::Scene scene = parabola();
    scene.indenter.shape = shape;
    scene.load.indentation = {0.1};
    const fem::ContactSolution answer = fem::solve_gap_reference(scene);
    const auto found = mesh_error(scene, answer);
    ASSERT_TRUE(found);
    const AnswerError truth = true_error(scene, answer, 161, 41);
    for (const auto member : {&AnswerError::S, &AnswerError::P, &AnswerError::Q})
      EXPECT_GE(found->expected.*member, truth.*member) << fem::shape_name(shape);
  }
}

TEST(MeshError, ShrinksWithTheMesh) {
  const fem::Scene coarse = parabola(), fine = on_mesh(coarse, 81, 21);
  const auto of_coarse = mesh_error(coarse, fem::solve_gap_reference(coarse));
  const auto of_fine = mesh_error(fine, fem::solve_gap_reference(fine));
  ASSERT_TRUE(of_coarse && of_fine);
  for (const auto member : error_members) EXPECT_LT(of_fine->expected.*member, of_coarse->expected.*member);
}

TEST(MeshError, IsLeftOutWhereItWouldTakeSeconds) {
  const fem::Scene scene = parabola();
  fem::ContactSolution answer = fem::solve_gap_reference(scene);
  EXPECT_FALSE(mesh_error(on_mesh(scene, 121, 11), answer));
  EXPECT_FALSE(mesh_error(on_mesh(scene, 41, 41), answer));
  answer.steps.resize(101, answer.steps.back());
  EXPECT_FALSE(mesh_error(scene, answer));
}

// Where nothing touches on either mesh there is nothing to be off.
TEST(MeshError, IsNoneWithoutContact) {
  fem::Scene scene = parabola();
  scene.load = {};
  scene.load.indentation = {0.0};
  const auto found = mesh_error(scene, fem::solve_gap_reference(scene));
  ASSERT_TRUE(found);
  for (const auto member : error_members) EXPECT_EQ(found->expected.*member, 0);
}

// Q of a symmetric indenter that is only pressed is rounding, some 1e-17 N/mm: its relative difference means nothing.
TEST(MeshError, IsNoneOfARoundingThatIsQ) {
  SolveOutcome outcome{.scene = parabola()};
  outcome.scene.load = {};
  outcome.scene.load.indentation = {0.05, 0.15, 0.05};
  outcome.solution = fem::solve_gap_reference(outcome.scene);
  const auto found = mesh_error(outcome);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->expected.Q, 0);
  EXPECT_GT(found->expected.P, 0.01);
}

// The planner's own estimate of S, and twice the differences from the finer rung; of the finest rung, these themselves.
TEST(MeshError, OfAPlanIsThePlanners) {
  RungChoice plan{.accuracy = 0.02, .rung = rung_named("paper"), .estimate = 0.0125, .kept = true};
  EXPECT_FALSE(mesh_error(plan));
  plan.trials = {{.rung = "paper",
                  .next = "medium",
                  .difference = {.S = 0.006, .P = 0.03, .Q = 0.02, .sigma = 0.05, .tau = 0.04},
                  .estimate = 0.0125}};
  const auto kept = mesh_error(plan);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->from, "rung medium");
  EXPECT_EQ(kept->expected.S, 0.0125);
  EXPECT_DOUBLE_EQ(kept->expected.P, 0.06);
  EXPECT_DOUBLE_EQ(kept->expected.Q, 0.04);
  EXPECT_DOUBLE_EQ(kept->expected.sigma, 0.10);
  EXPECT_DOUBLE_EQ(kept->expected.tau, 0.08);
  plan.rung = rung_named("medium");
  EXPECT_EQ(mesh_error(plan)->from, "rung paper");
  EXPECT_DOUBLE_EQ(mesh_error(plan)->expected.P, 0.03);
  plan.trials[0].missed = true;
  EXPECT_FALSE(mesh_error(plan));
}

TEST(MeshError, StandsInTableAndJsonWhereItIsKnown) {
  SolveOutcome outcome{fem::solve_gap_reference(parabola()), "reference", "fp64", "host"};
  outcome.scene = parabola();
  EXPECT_FALSE(to_json(outcome).contains("discretisation_error"));
  EXPECT_THAT(answer_table(outcome), Not(HasSubstr("error of the mesh")));
  outcome.error = ExpectedError{{.S = 0.02, .P = 0.045, .Q = 0.05, .sigma = 0.1, .tau = 0.125}, "81 x 21"};
  const auto json = to_json(outcome)["discretisation_error"];
  EXPECT_EQ(json["slip_index"], 0.02);
  EXPECT_EQ(json["P"], 0.045);
  EXPECT_EQ(json["tau_xy"], 0.125);
  EXPECT_EQ(json["from"], "81 x 21");
  EXPECT_THAT(answer_table(outcome), HasSubstr("error of the mesh to expect (from 81 x 21): S 0.02,\n"
                                               "  P 4.5 %, Q 5 %, sigma_y 10 %, tau_xy 12 % of the largest\n"));
  EXPECT_THAT(answer_table(outcome), HasSubstr("surface nodes "));
  outcome.solution.surface_width = Eigen::VectorXd::Constant(12, 0.1);
  EXPECT_THAT(answer_table(outcome), AllOf(HasSubstr("error of the patch to expect (from 81 x 21): S 0.02,\n"),
                                           HasSubstr("Q/mu P        elements ")));
}

}  // namespace tactel::host::line_error_test
