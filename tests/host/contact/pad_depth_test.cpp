// SPDX-License-Identifier: Apache-2.0

// Tactels within the rubber: the kernels beside the twin. Stress is a table of quadratics, 32 rows for each length of
// the tactels' depth below the surface, and a sum over points of cells, 0.4 of it apart.
#include <gtest/gtest.h>

#include <vector>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "host/contact/pads/pad_contact.h"
#include "host/contact/pads/pad_stream.h"
#include "tests/host/contact/stepped.h"

namespace tactel::host::pad_depth_test {

void expect_twin(const fem::PadSensor& sensor, double height) {
  fem::PadMix draw(5, &sensor);
  std::vector<fem::PadScene> scenes(10);
  for (fem::PadScene& scene : scenes) scene = draw(), scene.sensor.depth = height * scene.sensor.thickness;
  auto batch = PadContact<double>(executor(), {.cells = 8, .tolerance = 1e-9}).prepare(scenes);
  batch.run();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadLayer layer = fem::pad_layer(batch.scene(i));
    const fem::PadSolution a = batch.solution(i), b = fem::PadSolver(layer, {.cells = 8, .tolerance = 1e-9})
                                                          .solve_on(batch.cells(i), batch.scene(i));
    for (std::size_t k = 0; k < b.steps.size(); ++k) {
      EXPECT_NEAR(a.steps[k].P, b.steps[k].P, 1e-6 * b.steps[k].P) << i << " " << k;
      EXPECT_LT((a.steps[k].stress - b.steps[k].stress).cwiseAbs().maxCoeff(),
                2e-3 * b.steps[k].stress.cwiseAbs().maxCoeff())
          << i << " " << k << " " << height;
    }
  }
}

TEST(PadDepth, AgreesWithTheTwin) {
  for (const double height : {0.05, 0.5, 0.75}) expect_twin(rubber, height);
}
TEST(PadDepth, AgreesWithTheTwinBelowACover) {
  fem::PadSensor covered = rubber;
  const double H = rubber.thickness;
  covered.layers = {{0.8 * H, rubber.young, rubber.poisson}, {0.2 * H, 5 * rubber.young, 0.48}};
  expect_twin(with_layers(covered), 0.75);
}

// Scenes of one launch have their tactels alike: others have another key.
TEST(PadDepth, OtherDepthsAreOtherLaunches) {
  fem::PadMix draw(5, &rubber);
  fem::PadScene base = draw(), higher = base;
  higher.sensor.depth = 0.5 * higher.sensor.thickness;
  EXPECT_NE(PadContacts::key(base), PadContacts::key(higher));
  const PadStream stream(executor(), {.options = {.cells = 8}});
  const std::vector<fem::PadScene> scenes{base, higher, base};
  const std::vector<fem::PadSolution> all = stream.solve(scenes), alone = stream.solve(std::span(scenes).subspan(1, 1));
  EXPECT_EQ(all[1].steps[0].stress, alone[0].steps[0].stress);
  EXPECT_EQ(all[0].steps[0].stress, all[2].steps[0].stress);
  EXPECT_GT(all[1].steps[0].stress.cwiseAbs().maxCoeff(), all[0].steps[0].stress.cwiseAbs().maxCoeff());
}

TEST(PadDepth, StepsHaveTheStressOfTheirTractions) {
  fem::PadSensor pad = rubber;
  pad.depth = 0.5 * pad.thickness;
  PadStepper<double> steps(executor(), pad, 1, std::array{0.5}, {.cells = {10, 12}, .cell = {0.28, 0.25}});
  steps.set_surface(0, fem::pad_surface(steps.cells(), {.shape = fem::Sphere{5}}, {0, 0}, 0));
  steps.move(std::array{0.12, 0.0, 0.0, 0.0}), steps.move(std::array{0.12, 0.03, 0.0, 0.0});
  const std::vector<double> tractions = steps.tractions();  // n, t_x, t_y
  fem::PadScene alone;
  alone.sensor = pad;
  const Eigen::MatrixXd rows = fem::base_stress_of_cells(fem::pad_layer(alone), alone, steps.cells());
  const Eigen::VectorXd expected = rows * Eigen::Map<const Eigen::VectorXd>(tractions.data(), rows.cols());
  const auto found = steps.frames();
  ASSERT_EQ(static_cast<Eigen::Index>(found.size()), expected.size());
  for (Eigen::Index k = 0; k < expected.size(); ++k)
    EXPECT_NEAR(found[static_cast<std::size_t>(k)], expected[k], 1e-9 * expected.cwiseAbs().maxCoeff()) << k;
  // A state goes on at another depth: the contact is the same.
  PadStepper<double> base(executor(), rubber, 1, std::array{0.5}, {.cells = {10, 12}, .cell = {0.28, 0.25}});
  base.set_state(steps.state());
}

}  // namespace tactel::host::pad_depth_test
