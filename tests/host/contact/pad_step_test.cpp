// SPDX-License-Identifier: Apache-2.0

// Steps against the path that pad_contact solves, against themselves in other batches, orders and lanes, against the
// wrench that was asked, and against laws of friction.
#include "host/contact/pad_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "bench/stepped_bowls.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_step.h"
#include "fem/value_error.h"
#include "host/contact/pad_contact.h"
#include "kernels/shared/pad_layout.h"
#include "kernels/shared/pad_step_layout.h"
#include "tests/host/device/test_device.h"

namespace tactel::host {
namespace {

using bench::Bowls;

const fem::PadSensor rubber{.tactels = {4, 4}, .pitch = {0.6, 0.6}, .thickness = 2, .young = 1.5, .poisson = 0.45};

template <class Real>
double number(const PadStepper<Real>& steps, std::size_t contact, int row) {
  return static_cast<double>(steps.results()[contact * STEP_RESULT_ROWS + static_cast<std::size_t>(row)]);
}

/// The increments of a path, one a step, have the bits of the path: same cells about the pad's middle, same heights.
template <class Real>
void expect_path(int cells, double poisson) {
  fem::PadSensor sensor = rubber;
  sensor.poisson = poisson;
  const double side = sensor.thickness * std::exp2(cells == 8 ? -2.5 : -3.0);  // on the ladder: one table for both
  const PadContact<Real> contact(executor(), {.cells = cells, .tolerance = 1e-3});
  fem::PadMix draw(7, &sensor);
  std::vector<fem::PadScene> scenes;
  std::vector<fem::PadCells> grids;
  while (scenes.size() < 20) {
    fem::PadScene scene = draw();
    const auto* sphere = std::get_if<fem::Sphere>(&scene.indenter.shape);
    const auto* bowl = std::get_if<fem::Paraboloid>(&scene.indenter.shape);
    if (!sphere && !bowl) continue;  // those that no edge ends
    scene.indenter.position = {0, 0}, scene.indenter.yaw = 0;
    scenes.push_back(scene);
    grids.push_back(fem::fixed_cells(cells, side));
  }
  const auto batch = [&] {
    auto made = contact.prepare(scenes, grids);
    made.run();
    return made;
  }();
  std::vector<double> mu, pose(4 * scenes.size());
  for (const fem::PadScene& scene : scenes) mu.push_back(scene.friction);
  PadStepper<Real> steps(executor(), sensor, scenes.size(), mu, {.cells = cells, .cell = side, .most_sweeps = 2000});
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Eigen::MatrixXd ring = fem::cell_heights(grids[i], scenes[i].indenter);
    fem::PadSurface surface{Eigen::ArrayXd(cells * cells), Eigen::ArrayXd::Ones(cells * cells)};
    for (int k = 0; k < cells * cells; ++k) surface.height[k] = ring(k / cells + 1, k % cells + 1);
    steps.set_surface(i, surface);
  }
  std::vector<std::vector<fem::PadIncrement>> paths;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    paths.push_back(fem::pad_increments(scenes[i], contact.options(), grids[i]));
    longest = std::max(longest, paths.back().size());
  }
  std::vector<int> slot(scenes.size());
  std::size_t compared = 0;
  for (std::size_t k = 0; k < longest; ++k) {
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const fem::PadTarget& to = paths[i][std::min(k, paths[i].size() - 1)].target;
      const double all[4] = {to.normal, to.x, to.y, to.twist};
      std::copy_n(all, 4, &pose[4 * i]);
    }
    steps.move(pose);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      if (k >= paths[i].size() || !paths[i][k].asked) continue;
      const int at = slot[i]++;
      const auto same = [&](int row, int path_row) {
        EXPECT_EQ(number(steps, i, row), batch.result(i, at, path_row)) << i << " " << k << " " << row;
      };
      same(STEP_RESULT_P, RESULT_P), same(STEP_RESULT_QX, PAD_RESULT_QX), same(STEP_RESULT_QY, PAD_RESULT_QY);
      same(STEP_RESULT_M, PAD_RESULT_M), same(STEP_RESULT_S, RESULT_S), same(STEP_RESULT_SWEEPS, RESULT_SWEEPS);
      ++compared;
    }
  }
  EXPECT_GE(compared, 6 * scenes.size());
}

TEST(PadStep, HasTheBitsOfThePathInFp32) {
  expect_path<float>(8, 0.45);
  expect_path<float>(12, 0.5);
}

TEST(PadStep, HasTheBitsOfThePathInFp64) { expect_path<double>(8, 0.3); }

/// Presses by motion, and returns the forces P.
std::vector<double> pressed(PadStepper<float>& steps, const Bowls& bowls) {
  for (int k = 0; k < 4; ++k) steps.move(bowls.pose(k));
  std::vector<double> P;
  for (std::size_t c = 0; c < bowls.count; ++c) P.push_back(number(steps, c, STEP_RESULT_P));
  return P;
}

std::vector<float> rows_of(const PadStepper<float>& steps, std::size_t contact) {
  const auto all = steps.results().subspan(contact * STEP_RESULT_ROWS, STEP_RESULT_ROWS);
  return {all.begin(), all.end()};
}

/// Rows of results of contacts on their way: eight steps by motion, then as many by wrench.
std::vector<std::vector<std::vector<float>>> way(PadStepper<float>& steps, const Bowls& all,
                                                 std::span<const std::size_t> which, std::span<const double> P) {
  std::vector<std::vector<std::vector<float>>> rows;
  const auto some = [&](const std::vector<double>& of_all) {
    std::vector<double> numbers;
    for (const std::size_t c : which) numbers.insert(numbers.end(), &of_all[4 * c], &of_all[4 * c] + 4);
    return numbers;
  };
  for (int k = 0; k < 16; ++k) {
    if (k < 8)
      steps.move(some(all.pose(k)));
    else
      steps.press(some(all.wrench(k - 7, P, 1.1)));
    rows.emplace_back();
    for (std::size_t c = 0; c < which.size(); ++c) rows.back().push_back(rows_of(steps, c));
  }
  return rows;
}

TEST(PadStep, HasTheSameBitsInAnyBatchOrderAndLanes) {
  const Bowls all(600, 3);  // which has two vectors a work-item where the processor is wide
  std::vector<std::size_t> every(all.count);
  std::iota(every.begin(), every.end(), 0);
  Executor wide(Device("basic").with_halves(false));
  PadStepper<float> steps = all.steps(wide);
  const std::vector<double> P = pressed(steps, all);
  steps.reset();
  const auto expected = way(steps, all, every, P);
  std::vector<std::size_t> some = every;
  std::shuffle(some.begin(), some.end(), std::mt19937(5));
  some.resize(37);
  const Device basic("basic");
  for (const Device& device : {basic, basic.with_lanes(4), basic.as_gpu()}) {
    Executor own(device);
    PadStepper<float> others = all.of(some).steps(own);
    const auto rows = way(others, all, some, P);
    for (std::size_t k = 0; k < rows.size(); ++k)
      for (std::size_t c = 0; c < some.size(); ++c)
        ASSERT_EQ(rows[k][c], expected[k][some[c]]) << k << " " << c << " lanes " << others.lanes();
  }
}

TEST(PadStep, GoesOnFromAStateWithTheSameBits) {
  const Bowls all(20, 4);
  PadStepper<float> steps = all.steps(executor());
  const std::vector<double> P = pressed(steps, all);
  for (int k = 1; k < 6; ++k) steps.press(all.wrench(k, P, 0.9));
  const std::array<std::size_t, 3> some{17, 2, 5};
  const std::vector<float> state = steps.state(some);
  EXPECT_EQ(state.size(), some.size() * steps.state_rows());
  PadStepper<float> others = all.of(some).steps(executor());
  others.set_state(state);
  EXPECT_EQ(others.state(), state);
  for (int k = 6; k < 12; ++k) {
    const std::vector<double> wrench = all.wrench(k, P, 0.9);
    std::vector<double> own;
    for (const std::size_t c : some) own.insert(own.end(), &wrench[4 * c], &wrench[4 * c] + 4);
    steps.press(wrench), others.press(own);
    for (std::size_t c = 0; c < some.size(); ++c)
      EXPECT_EQ(rows_of(others, c), rows_of(steps, some[c])) << k << " " << c;
    const std::size_t rows = 3 * steps.tactels();
    for (std::size_t c = 0; c < some.size(); ++c)
      for (std::size_t r = 0; r < rows; ++r)
        EXPECT_EQ(others.frames()[c * rows + r], steps.frames()[some[c] * rows + r]);
  }
}

TEST(PadStep, ResetsThoseOfAMask) {
  const Bowls all(5, 4);
  PadStepper<float> steps = all.steps(executor()), fresh = all.steps(executor());
  pressed(steps, all);
  steps.move(all.pose(6));
  const std::array<std::uint8_t, 5> mask{0, 1, 0, 1, 0};
  steps.reset(mask);
  steps.move(all.pose(0)), fresh.move(all.pose(0));
  for (const std::size_t c : {1, 3}) EXPECT_EQ(rows_of(steps, c), rows_of(fresh, c));
  for (const std::size_t c : {0, 2, 4}) EXPECT_NE(rows_of(steps, c), rows_of(fresh, c));
}

TEST(PadStep, NeedsNoCellsBeyondItsReach) {
  const Bowls all(64, 6);
  PadStepper<float> near = all.steps(executor()), far = all.steps(executor());
  far.set_reach(1e9);
  const std::vector<double> P = pressed(near, all);
  pressed(far, all);
  for (int k = 4; k < 30; ++k) {
    if (k < 16)
      near.move(all.pose(k)), far.move(all.pose(k));
    else
      near.press(all.wrench(k, P, 1.2)), far.press(all.wrench(k, P, 1.2));
    for (std::size_t c = 0; c < all.count; ++c) ASSERT_EQ(rows_of(near, c), rows_of(far, c)) << k << " " << c;
  }
}

/// What a wrench asks, against what a contact has, over P: the largest of P, Qx, Qy.
double miss(const PadStepper<float>& steps, std::size_t c, std::span<const double> wrench) {
  double most = 0;
  for (int k = 0; k < 3; ++k)
    most = std::max(most, std::abs(number(steps, c, STEP_RESULT_P + k) - wrench[4 * c + static_cast<std::size_t>(k)]));
  return most / wrench[4 * c];
}

int flags_of(const PadStepper<float>& steps, std::size_t c) {
  return static_cast<int>(number(steps, c, STEP_RESULT_FLAGS));
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

TEST(PadStep, SaysWhatItDoesNotServe) {
  const auto made = [](const StepOptions& options, std::span<const double> friction) {
    PadStepper<float>(executor(), rubber, 3, friction, options);
  };
  const std::array one{0.5};
  EXPECT_THROW(made({.cells = 3}, one), ValueError);
  EXPECT_THROW(made({.cell = 0}, one), ValueError);
  EXPECT_THROW(made({.sides = "free"}, one), ValueError);
  EXPECT_THROW(made({.tolerance = -1}, one), ValueError);
  EXPECT_THROW(made({}, std::array{0.5, -0.1, 0.5}), ValueError);
  EXPECT_THROW(made({}, std::array{0.5, 0.5}), ValueError);
}

TEST(PadStep, LeavesAContactWithoutInputAsItWas) {
  const Bowls all(3, 12);
  PadStepper<float> steps = all.steps(executor()), others = all.steps(executor());
  pressed(steps, all), pressed(others, all);
  std::vector<double> pose = all.pose(5);
  pose[4] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<float> before = steps.state(std::array<std::size_t, 1>{1});
  steps.move(pose), others.move(all.pose(5));
  EXPECT_TRUE(flags_of(steps, 1) & STEP_INVALID);
  EXPECT_EQ(steps.state(std::array<std::size_t, 1>{1}), before);
  for (const std::size_t c : {0, 2}) EXPECT_EQ(rows_of(steps, c), rows_of(others, c));
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

}  // namespace
}  // namespace tactel::host
