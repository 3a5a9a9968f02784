// SPDX-License-Identifier: Apache-2.0

// Steps of objects over most of the grid, which are split, against the twin, against sweeps, and against laws.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_step.h"
#include "tests/host/contact/stepped.h"

namespace tactel::host::pad_step_split_test {

using Pose = std::array<double, 4>;

/// An uneven face that tilts, over H, and parts of its cells.
fem::PadSurface face(const fem::PadCells& cells, double tilt) {
  fem::PadSurface surface{Eigen::ArrayXd(cells.count()), Eigen::ArrayXd::Ones(cells.count())};
  for (int i = 0; i < cells.count(); ++i) {
    const double x = cells.x(i / cells.ny()), y = cells.y(i % cells.ny());
    surface.height[i] = tilt * (x + 0.4 * y) + 0.01 * std::sin(3 * x) * std::cos(2 * y);
    if (i % 5 == 0) surface.cover[i] = 0.6;
  }
  surface.height -= surface.height.minCoeff();
  return surface;
}

/// Presses, drags with a turn until much of it slides, and goes back.
Pose face_pose(int k, double mu) {
  const double drag = 0.02 * (mu + 0.2) * std::max(0, k < 10 ? k - 4 : 16 - k);
  return {std::min(0.03 * k, 0.12), drag, -0.3 * drag, 0.1 * drag};
}

/// fp64 with fine tolerances beside the twin, which sweeps: forces to what a thousand sweeps leave.
void expect_twin(double nu, double mu, double tilt, AlongXY<int> cells) {
  fem::PadSensor pad = rubber;
  pad.poisson = nu;
  PadStepper<double> steps(executor(), pad, 1, std::array{mu},
                           {.cells = cells, .cell = {0.4, 0.3}, .tolerance = 1e-8, .most_sweeps = 4000});
  fem::SteppedContact twin(fem::pad_layer(nu), pad, steps.cells(), mu,
                           {.cells = cells.x, .tolerance = 1e-8, .accept = 1e-6});
  const fem::PadSurface surface = face(steps.cells(), tilt);
  steps.set_surface(0, surface), twin.set_surface(surface, {0, 0});
  for (int k = 1; k <= 14; ++k) {
    const Pose to = face_pose(k, mu);
    steps.move(to);
    const fem::SteppedState state = twin.move(to[0], {to[1], to[2], to[3]});
    for (int row = 0; row < 4; ++row)
      EXPECT_NEAR(number(steps, 0, STEP_RESULT_P + row), state.force[row], 2e-5 * state.force[0])
          << k << " row " << row << " nu " << nu << " mu " << mu;
    EXPECT_EQ(number(steps, 0, STEP_RESULT_TOUCH), state.touching);
    EXPECT_EQ(static_cast<int>(number(steps, 0, STEP_RESULT_FLAGS)) & STEP_UNMET, 0);
  }
}

TEST(PadStepSplit, AgreesWithTheTwin) {
  expect_twin(0.45, 0.5, 0.01, {8, 8});
  expect_twin(0.3, 0.3, 0.03, {7, 9});  // with middle lines of cells
}
TEST(PadStepSplit, AgreesWithTheTwinAtTheEndsOfWhatIsServed) {
  expect_twin(0.4999, 0.5, 0.01, {7, 9});
  expect_twin(0.1, 0, 0.01, {7, 9});
  expect_twin(0.1, 5, 0.02, {7, 9});
}

/// What most contacts of a batch take, and that those that cover little keep the bits of sweeps.
TEST(PadStepSplit, IsWithinToleranceOfSweepsAndLeavesTheNarrowAlone) {
  const Bowls all = covering(64, 21);
  PadStepper<float> steps = all.steps(executor()), swept = all.steps(executor());
  swept.set_wide_share(2);
  const std::vector<double> P = pressed(steps, all);
  pressed(swept, all);
  int narrow = 0, split = 0;
  for (int k = 4; k < 20; ++k) {
    if (k < 14)
      steps.move(all.pose(k)), swept.move(all.pose(k));
    else
      steps.press(all.wrench(k, P, 0.8)), swept.press(all.wrench(k, P, 0.8));
    for (std::size_t c = 0; c < all.count; ++c) {
      if (c % 4 == 0) {
        narrow += rows_of(steps, c) == rows_of(swept, c);
        continue;
      }
      split += number(steps, c, STEP_RESULT_SWEEPS) != number(swept, c, STEP_RESULT_SWEEPS);
      const double load = number(swept, c, STEP_RESULT_P), near = k < 14 ? 2e-3 : 6e-3;  // tolerances, of both
      EXPECT_NEAR(number(steps, c, STEP_RESULT_P) / load, 1, near) << k << " " << c;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_QX), number(swept, c, STEP_RESULT_QX), near * load) << k << " " << c;
      EXPECT_NEAR(number(steps, c, STEP_RESULT_S), number(swept, c, STEP_RESULT_S), 5 * near) << k << " " << c;
    }
  }
  EXPECT_EQ(narrow, 16 * 16);
  EXPECT_GE(split, 48 * 10);
}

/// Laws of a face that slides as a whole: |Q| = mu P in every state, and tractions against the way.
TEST(PadStepSplit, AFaceThatSlidesBearsMuP) {
  for (const double mu : {0.0, 0.4, 5.0}) {
    PadStepper<float> steps(executor(), rubber, 1, std::array{mu}, {.cells = 8, .cell = 0.4});
    const std::vector<double> flat(64, 0.0);
    steps.set_heights(std::span<const double>(flat));
    for (int k = 1; k <= 4; ++k) steps.move(Pose{0.02 * k, 0, 0, 0});
    for (int k = 1; k <= 12; ++k) steps.move(Pose{0.08, (0.05 + mu) * k, 0, 0});
    const double P = number(steps, 0, STEP_RESULT_P);
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_QX), mu * P, 1e-3 * mu * P);  // rubber is dragged a little across
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_QY), 0, 1e-3 * mu * P);
    EXPECT_EQ(number(steps, 0, STEP_RESULT_STICK), 0);
    EXPECT_EQ(number(steps, 0, STEP_RESULT_TOUCH), 64);
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_S), mu > 0 ? 1 : 0, 1e-3);
  }
}

/// The surface that tractions give by the layer's influence lies at the face where cells press, and not within it.
TEST(PadStepSplit, ItsTractionsHoldTheFace) {
  PadStepper<float> steps(executor(), rubber, 1, std::array{0.5}, {.cells = 8, .cell = 0.4});
  const fem::PadCells& cells = steps.cells();
  fem::PadSurface surface = face(cells, 0.05);
  surface.cover.setOnes();
  steps.set_surface(0, surface);
  for (int k = 1; k <= 12; ++k) steps.move(face_pose(k, 0.5));
  const double depth = face_pose(12, 0.5)[0];
  const std::vector<double> t = steps.tractions();
  const std::vector<fem::CellInfluence> all = fem::pad_layer(rubber.poisson).influences(rubber.thickness, 0.4, 0.4, 8);
  for (int i = 0; i < 64; ++i) {
    double u = 0;
    for (int j = 0; j < 64; ++j) {
      const int dx = i / 8 - j / 8, dy = i % 8 - j % 8, offset = std::abs(dx) * 9 + std::abs(dy);
      const fem::CellInfluence& c = all[static_cast<std::size_t>(offset)];
      const auto at = static_cast<std::size_t>(j);
      u -= (c.zz * t[at] + (dx < 0 ? -1 : 1) * c.xz * t[64 + at] + (dy < 0 ? -1 : 1) * c.yz * t[128 + at]) /
           rubber.young;
    }
    const double gap = surface.height[i] - depth - u;
    EXPECT_GE(gap, -2e-2 * depth) << i;  // what is accepted
    EXPECT_TRUE(t[static_cast<std::size_t>(i)] == 0 || gap <= 2e-2 * depth) << i << " " << gap;
  }
}

/// Iterations that may not settle leave the contact to sweeps, and what those do not settle is said.
TEST(PadStepSplit, GoesOnWithSweeps) {
  const Bowls all = covering(16, 22);
  PadStepper<float> hurried = all.steps(executor(), {.tolerance = 1e-4, .most_sweeps = 2});
  PadStepper<float> steps = all.steps(executor(), {.tolerance = 1e-4, .most_sweeps = 2000});
  hurried.move(all.pose(3)), steps.move(all.pose(3));
  int split = 0;
  for (std::size_t c = 0; c < all.count; ++c) {
    split += number(hurried, c, STEP_RESULT_SWEEPS) == 4;  // two of each
    EXPECT_TRUE(flags_of(hurried, c) & STEP_UNMET);
    EXPECT_EQ(flags_of(steps, c) & STEP_UNMET, 0);
    EXPECT_NEAR(number(hurried, c, STEP_RESULT_P) / number(steps, c, STEP_RESULT_P), 1, 0.2);
  }
  EXPECT_GE(split, 6);
}

/// Steps of any size and kind: every contact is solved.
void expect_none_lost(int jumps) {
  const Bowls all = covering(256, 23);
  PadStepper<float> steps = all.steps(executor(), {.most_sweeps = 2000});
  std::mt19937 random(24);
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  int unmet = 0;
  for (int k = 0; k < jumps / 256; ++k) {
    std::vector<double> to;
    for (std::size_t c = 0; c < all.count; ++c) {
      const double d = all.depth[c];
      to.insert(to.end(), {d * within(0, 1.3), d * within(-1, 1), d * within(-1, 1), d * within(-1, 1)});
    }
    steps.move(to);
    for (std::size_t c = 0; c < all.count; ++c) {
      for (const float value : rows_of(steps, c)) ASSERT_TRUE(std::isfinite(value)) << k << " " << c;
      unmet += (flags_of(steps, c) & STEP_UNMET) != 0;
    }
  }
  EXPECT_EQ(unmet, 0);
}
TEST(PadStepSplit, LosesNoJump) { expect_none_lost(2560); }
TEST(PadStepSplitNightly, LosesNoJump) { expect_none_lost(100'000); }

/// A table that is not its own image keeps its sweeps.
TEST(PadStepSplit, ATableWithoutSymmetryIsSwept) {
  const Bowls all = covering(8, 25);
  const fem::PadCells& cells = all.cells;
  const std::vector<fem::CellInfluence> layer = fem::pad_layer(all.pad.poisson).influences(1, cells.hx, cells.hy, 8);
  PairInfluence pairs;
  for (int place = 0; place < 64; ++place)
    for (int source = 0; source < 64; ++source) {
      const int dx = place / 8 - source / 8, dy = place % 8 - source % 8, offset = std::abs(dx) * 9 + std::abs(dy);
      fem::CellInfluence c = layer[static_cast<std::size_t>(offset)];
      if (dx < 0) c.xz = -c.xz, c.xy = -c.xy;
      if (dy < 0) c.yz = -c.yz, c.xy = -c.xy;
      const double softer = place == source && place < 8 ? 1.3 : 1;  // a row at one side
      pairs.insert(pairs.end(), {softer * c.xx, c.xy, c.xz, c.xy, softer * c.yy, c.yz, -c.xz, -c.yz, softer * c.zz});
    }
  const auto made = [&] {
    PadStepper<float> steps(executor(), all.pad, all.count, all.friction, {.cells = 8, .cell = 0.14}, pairs);
    steps.set_heights(std::span<const double>(all.heights));
    return steps;
  };
  PadStepper<float> steps = made(), swept = made();
  swept.set_wide_share(2);
  pressed(steps, all), pressed(swept, all);
  for (std::size_t c = 0; c < all.count; ++c) EXPECT_EQ(rows_of(steps, c), rows_of(swept, c));
}

}  // namespace tactel::host::pad_step_split_test
