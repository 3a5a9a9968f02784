// SPDX-License-Identifier: Apache-2.0

// Steps against their twin, against paths on many fitted cells, and the frames that they give.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fem/pad/pad_step.h"
#include "host/contact/pads/pad_contact.h"
#include "tests/host/contact/stepped.h"

namespace tactel::host::pad_step_accuracy_test {

/// The kernel, in fp64, and its twin: the same cells, histories, covers and axes; other searches for a pose.
TEST(PadStep, AgreesWithItsTwinInFp64) {
  const fem::PadCells cells = fem::fixed_cells(8, 0.35);
  const fem::PadLayer layer(rubber.poisson);
  fem::PadOptions options;
  options.cells = 8, options.tolerance = 1e-8, options.accept = 1e-6;
  fem::SteppedContact twin(layer, rubber, cells, 0.5, options);
  PadStepper<double> steps(executor(), rubber, 1, std::array{0.5},
                           {.cells = 8, .cell = 0.35, .tolerance = 1e-8, .force_tolerance = 1e-6, .most_sweeps = 2000});
  const fem::PadIndenter box{.shape = fem::Box{.half_widths = {0.72, 0.55}}};
  const auto put = [&](double x, double y, double yaw) {
    const fem::PadSurface surface = fem::pad_surface(cells, box, {x, y}, yaw);
    steps.set_surface(0, surface), steps.set_axes(std::array{x, y});
    twin.set_surface(surface, {x, y});
  };
  const auto expect_near = [&](const fem::SteppedState& expected, double near) {
    const double P = expected.force[0];
    for (int k = 0; k < 4; ++k)
      EXPECT_NEAR(static_cast<double>(steps.results()[static_cast<std::size_t>(k)]), expected.force[k], near * P) << k;
    EXPECT_NEAR(static_cast<double>(steps.results()[STEP_RESULT_S]), expected.slip_index, 1e-3 + near);  // four rounds
    EXPECT_EQ(static_cast<double>(steps.results()[STEP_RESULT_TOUCH]), expected.touching);
    EXPECT_TRUE(expected.met);
  };
  double pose[4] = {0, 0, 0, 0};
  for (int k = 1; k <= 10; ++k) {  // pressed, then dragged and turned, while the box travels
    pose[0] = std::min(0.02 * k, 0.1);
    if (k > 5) pose[1] += 0.02, pose[2] += 0.005, pose[3] += 0.01;
    put(0.11 + pose[1], -0.07 + pose[2], 10 + 57.295779513 * pose[3]);
    steps.move(pose);
    expect_near(twin.move(pose[0], {pose[1], pose[2], pose[3]}), 1e-5);  // 1000 sweeps' tolerances
  }
  const auto& at = steps.results();
  fem::PadWrench wrench(at[STEP_RESULT_P], at[STEP_RESULT_QX], at[STEP_RESULT_QY], at[STEP_RESULT_M]);
  for (int k = 1; k <= 3; ++k) {  // P grows, Q and M go back, at rest over the pad
    wrench[0] *= 1.05, wrench[1] *= 0.8, wrench[2] *= 0.7, wrench[3] *= 0.9;
    steps.press(std::span(wrench.data(), 4));
    expect_near(twin.press(wrench, 1e-6), 1e-4);  // the wrench to 1e-6; S by the other pose's history
  }
}

/// S of a press with drags on fixed cells against fine fitted ones.
double error_of_S(int across) {
  const fem::PadSensor pad{.thickness = 4, .young = 0.5, .poisson = 0.48};
  fem::PadScene scene{.sensor = pad, .indenter = {.shape = fem::Sphere{.radius = 12}}, .friction = 0.6};
  scene.load = {.indentation = {0.5}};
  for (int k = 1; k <= 6; ++k) scene.load.drags.push_back({0.06 * k, 0.02 * k * (k > 3), 0.02 * k});
  static const fem::PadSolution truth = [&] {
    auto fine = PadContact<float>(executor(), {.cells = 24, .parts = 4}).prepare(std::span(&scene, 1));
    fine.run();
    return fine.solution(0);
  }();
  const double width = truth.steps[0].reach.x.right - truth.steps[0].reach.x.left;
  PadStepper<float> steps(executor(), pad, 1, std::array{0.6}, {.cells = 20, .cell = width / across});
  steps.set_surface(0, fem::pad_surface(steps.cells(), scene.indenter, {0, 0}, 0));
  for (int k = 1; k <= 4; ++k) steps.move(std::array{0.125 * k, 0.0, 0.0, 0.0});
  double worst = 0;
  for (std::size_t k = 0; k < scene.load.drags.size(); ++k) {
    const auto [x, y, twist] = scene.load.drags[k];
    steps.move(std::array{0.5, x, y, twist});
    worst = std::max(worst, std::abs(number(steps, 0, STEP_RESULT_S) - *truth.steps[k + 1].slip_index));
  }
  return worst;
}

TEST(PadStep, IsRightBySoManyCellsAcross) {
  EXPECT_LE(error_of_S(6), 0.025);
  EXPECT_LE(error_of_S(8), 0.02);
  EXPECT_LE(error_of_S(12), 0.012);
  EXPECT_LE(error_of_S(18), 0.008);
}

/// A box with sharp edges keeps its force over cells that it covers in part.
TEST(PadStep, KeepsTheForceOfASharpBoxThatTravels) {
  const fem::PadIndenter box{.shape = fem::Box{.half_widths = {2, 1.5}}};
  std::vector<double> P;
  for (int k = 0; k < 10; ++k) {
    PadStepper<float> steps(executor(), rubber, 1, std::array{0.5}, {.cells = 16, .cell = 0.4});
    steps.set_surface(0, fem::pad_surface(steps.cells(), box, {0.05 * k, 0.03 * k}, 0));
    steps.move(std::array{0.1, 0.0, 0.0, 0.0});
    P.push_back(number(steps, 0, STEP_RESULT_P));
  }
  const auto [least, most] = std::minmax_element(P.begin(), P.end());
  EXPECT_LE(*most / *least, 1.05);  // 24 % where a cell is covered or not
  fem::PadScene scene{.sensor = rubber, .indenter = box, .friction = 0.5};
  scene.load.indentation = {0.1};
  const double exact = fem::PadSolver(fem::PadLayer(rubber.poisson), {.cells = 24}).solve(scene).steps[0].P;
  for (const double force : P) EXPECT_NEAR(force / exact, 1, 0.06);
}

/// Base stress of a step against that of the twin of paths, from the tractions by the layer's kernels.
TEST(PadStep, GivesTheFramesOfItsTractions) {
  const Bowls all(3, 13);
  PadStepper<float> steps = all.steps(executor());
  pressed(steps, all);
  for (int k = 4; k < 7; ++k) steps.move(all.pose(k));
  const fem::PadScene scene{.sensor = all.pad};
  const Eigen::MatrixXd base = fem::base_stress_of_cells(fem::PadLayer(all.pad.poisson), scene, all.cells);
  const std::vector<double> tractions = steps.tractions();
  for (std::size_t c = 0; c < all.count; ++c) {
    const Eigen::VectorXd expected = base * Eigen::Map<const Eigen::VectorXd>(&tractions[c * 192], 192);
    const double most = expected.cwiseAbs().maxCoeff();
    for (Eigen::Index r = 0; r < expected.size(); ++r)
      EXPECT_NEAR(steps.frames()[c * 48 + static_cast<std::size_t>(r)], expected[r], 1e-5 * most);  // fp32, 64 cells
  }
}

}  // namespace tactel::host::pad_step_accuracy_test
