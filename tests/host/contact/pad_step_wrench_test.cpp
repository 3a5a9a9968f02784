// SPDX-License-Identifier: Apache-2.0

// Steps by wrench: what is met and in how many solves, on the cone and beyond it, in jumps, and held.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/host/contact/stepped.h"

namespace tactel::host::pad_step_wrench_test {

/// What a wrench asks, against what a contact has, over P: the largest of P, Qx, Qy.
double miss(const PadStepper<float>& steps, std::size_t c, std::span<const double> wrench) {
  double most = 0;
  for (int k = 0; k < 3; ++k)
    most = std::max(most, std::abs(number(steps, c, STEP_RESULT_P + k) - wrench[4 * c + static_cast<std::size_t>(k)]));
  return most / wrench[4 * c];
}

TEST(PadStep, MeetsAWrenchInFourSolves) {
  const Bowls all(256, 8);
  PadStepper<float> steps = all.steps(executor(), {.most_solves = 4});
  const std::vector<double> P = pressed(steps, all);
  steps.press(all.wrench(0, P, 0));
  std::vector<double> misses;
  for (int k = 1; k < 60; ++k) {
    const std::vector<double> wrench = all.wrench(k, P, 0.9);
    steps.press(wrench);
    for (std::size_t c = 0; c < all.count; ++c) {
      misses.push_back(miss(steps, c, wrench));
      EXPECT_LE(number(steps, c, STEP_RESULT_SOLVES), 4);
    }
  }
  std::sort(misses.begin(), misses.end());
  EXPECT_LE(misses[misses.size() * 95 / 100], 1e-2);
}

TEST(PadStep, SlidesOnTheConeBeyondIt) {
  const Bowls all(64, 9);
  PadStepper<float> steps = all.steps(executor());
  const std::vector<double> P = pressed(steps, all);
  std::vector<double> wrench = all.wrench(0, P, 0);
  steps.press(wrench);
  for (std::size_t c = 0; c < all.count; ++c) wrench[4 * c + 1] = 1.3 * all.friction[c] * wrench[4 * c];
  for (int k = 0; k < 3; ++k) steps.press(wrench);
  for (std::size_t c = 0; c < all.count; ++c) {
    const double load = all.friction[c] * number(steps, c, STEP_RESULT_P);
    const double ratio = std::hypot(number(steps, c, STEP_RESULT_QX), number(steps, c, STEP_RESULT_QY)) / load;
    EXPECT_GE(ratio, 0.99);
    EXPECT_LE(ratio, 1 + 1e-5);  // rounding of 64 cells
    EXPECT_TRUE(flags_of(steps, c) & STEP_SLIDES);
    EXPECT_FALSE(flags_of(steps, c) & STEP_UNMET);
    EXPECT_NEAR(number(steps, c, STEP_RESULT_P) / wrench[4 * c], 1, 2.1e-3);
  }
}

/// Wrenches that jump at random: none gives a number that is none, or a miss without a flag.
void expect_flagged_jumps(int jumps) {
  Bowls all(200, 10);
  PadStepper<float> steps = all.steps(executor());
  const std::vector<double> P = pressed(steps, all);
  steps.reset();
  int unmet = 0, pressing = 0;
  for (int k = 0; k < jumps / 200; ++k) {
    std::vector<double> wrench;
    for (std::size_t c = 0; c < all.count; ++c) {
      const double p = all.within(0, 1) < 0.1 ? 0 : P[c] * std::exp(all.within(-3.9, 0)),
                   q = all.friction[c] * p * all.within(0, 1.3), turn = all.within(0, 6.3);
      wrench.insert(wrench.end(), {p, q * std::cos(turn), q * std::sin(turn), 0.15 * q});
    }
    steps.press(wrench);
    for (std::size_t c = 0; c < all.count; ++c) {
      for (const float value : rows_of(steps, c)) ASSERT_TRUE(std::isfinite(value)) << k << " " << c;
      if (!(wrench[4 * c] > 0)) {
        EXPECT_EQ(flags_of(steps, c), STEP_OPEN);
        continue;
      }
      ++pressing;
      unmet += (flags_of(steps, c) & STEP_UNMET) != 0;
      if (!(flags_of(steps, c) & (STEP_UNMET | STEP_SLIDES))) {
        // The tolerance of a wrench, and rounding.
        ASSERT_LE(miss(steps, c, wrench), 2.1e-3) << k << " " << c;
      }
    }
  }
  EXPECT_LE(unmet, 0.15 * pressing);
}

TEST(PadStep, FlagsWhatJumpsMiss) { expect_flagged_jumps(2000); }
TEST(PadStepNightly, FlagsWhatJumpsMiss) { expect_flagged_jumps(100000); }

/// Contacts held at a part of the cone for many steps.
void expect_no_drift(int count) {
  const Bowls all(16, 11);
  PadStepper<float> steps = all.steps(executor());
  const std::vector<double> P = pressed(steps, all);
  std::vector<double> wrench;
  for (std::size_t c = 0; c < all.count; ++c) wrench.insert(wrench.end(), {P[c], 0.6 * all.friction[c] * P[c], 0, 0});
  for (int k = 1; k <= 4; ++k) {
    std::vector<double> part = wrench;
    for (std::size_t c = 0; c < all.count; ++c) part[4 * c + 1] *= k / 4.0;
    steps.press(part);
  }
  std::vector<std::vector<float>> first;
  for (std::size_t c = 0; c < all.count; ++c) first.push_back(rows_of(steps, c));
  for (int k = 0; k < count; ++k) steps.press(wrench);
  for (std::size_t c = 0; c < all.count; ++c)
    for (const int row : {STEP_RESULT_P, STEP_RESULT_QX, STEP_RESULT_S, STEP_RESULT_X})
      EXPECT_EQ(rows_of(steps, c)[static_cast<std::size_t>(row)], first[c][static_cast<std::size_t>(row)]);
  // A simulator's wrench trembles. S follows it to the tolerance of a wrench over mu, at whichever step.
  PadStepper<float> finer = all.steps(executor(), {.tolerance = 1e-4, .force_tolerance = 5e-5});
  finer.press(all.wrench(0, P, 0));
  for (int k = 0; k < count; ++k) {
    std::vector<double> trembling = wrench;
    for (std::size_t i = 0; i < wrench.size(); ++i)
      trembling[i] *= 1 + 1e-3 * std::sin(1.0 * k + static_cast<double>(i));
    finer.press(trembling);
  }
  finer.press(wrench);
  for (std::size_t c = 0; c < all.count; ++c) EXPECT_NEAR(number(finer, c, STEP_RESULT_S), 0.6, 1e-3);
  // By motion nothing moves, and heights that come anew change nothing.
  const std::vector<double> pose = steps.poses();
  steps.move(pose);
  const double held = number(steps, 3, STEP_RESULT_S);
  for (int k = 0; k < count; ++k) {
    steps.set_heights(std::span<const double>(all.heights));
    steps.move(pose);
  }
  EXPECT_EQ(number(steps, 3, STEP_RESULT_S), held);
}

TEST(PadStep, DoesNotDrift) { expect_no_drift(300); }
TEST(PadStepNightly, DoesNotDrift) { expect_no_drift(10000); }

/// Asked forces that nothing can bear: without an object, and across the pad without friction.
TEST(PadStep, SaysWhatNothingBears) {
  const fem::PadCells cells = fem::fixed_cells(8, 0.14);
  PadStepper<float> steps(executor(), rubber, 2, std::array{0.5, 0.0}, {.cells = 8, .cell = 0.14});
  steps.set_surface(1, fem::pad_surface(cells, {.shape = fem::Sphere{.radius = 2}}, {0, 0}, 0));
  const std::array<double, 8> wrench{0.05, 0.01, 0, 0, 0.05, 0.01, 0, 0};
  for (int k = 0; k < 2; ++k) steps.press(wrench);
  EXPECT_EQ(flags_of(steps, 0), STEP_OPEN | STEP_UNMET);
  EXPECT_EQ(flags_of(steps, 1), STEP_SLIDES);
  EXPECT_NEAR(number(steps, 1, STEP_RESULT_P), 0.05, 2.1e-3 * 0.05);
  EXPECT_EQ(number(steps, 1, STEP_RESULT_QX), 0);
  steps.set_surface(0, fem::pad_surface(cells, {.shape = fem::Sphere{.radius = 2}}, {0, 0}, 0));
  steps.press(wrench), steps.press(wrench);  // it comes, and is held
  EXPECT_EQ(flags_of(steps, 0), 0);
}

}  // namespace tactel::host::pad_step_wrench_test
