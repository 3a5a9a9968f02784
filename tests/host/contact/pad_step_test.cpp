// SPDX-License-Identifier: Apache-2.0

// Steps against the path that pad_contact solves, and against themselves in other batches, orders and lanes, and from a
// state.
#include "host/contact/pads/pad_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_step.h"
#include "host/contact/pads/pad_contact.h"
#include "kernels/shared/pad_layout.h"
#include "tests/host/contact/stepped.h"

namespace tactel::host::pad_step_test {

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
  steps.set_wide_share(2);  // paths are swept
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

/// Of 600 contacts, which have two vectors a work-item in sixteen lanes.
void expect_same_bits(const Bowls& all) {
  std::vector<std::size_t> every(all.count);
  std::iota(every.begin(), every.end(), 0);
  Executor wide(Device("basic").with_lanes(16).with_halves(false));
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

TEST(PadStep, HasTheSameBitsInAnyBatchOrderAndLanes) { expect_same_bits(Bowls(600, 3)); }
TEST(PadStepSplit, HasTheSameBitsInAnyBatchOrderAndLanes) { expect_same_bits(covering(600, 3)); }

void expect_to_go_on(const Bowls& all) {
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

TEST(PadStep, GoesOnFromAStateWithTheSameBits) { expect_to_go_on(Bowls(20, 4)); }
TEST(PadStepSplit, GoesOnFromAStateWithTheSameBits) { expect_to_go_on(covering(20, 4)); }

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
  near.set_wide_share(2), far.set_wide_share(2);
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

/// The layer's influence as a table of all pairs, x, y, z.
PairInfluence pairs_of(const Bowls& bowls) {
  const fem::PadCells& cells = bowls.cells;
  const int n = cells.n;
  const std::vector<fem::CellInfluence> all =
      fem::pad_layer(bowls.pad.poisson).influences(bowls.pad.thickness, cells.hx, cells.hy, n);
  PairInfluence pairs;
  for (int place = 0; place < n * n; ++place)
    for (int source = 0; source < n * n; ++source) {
      const int dx = place / n - source / n, dy = place % n - source % n,
                offset = std::abs(dx) * (n + 1) + std::abs(dy);
      fem::CellInfluence c = all[static_cast<std::size_t>(offset)];
      if (dx < 0) c.xz = -c.xz, c.xy = -c.xy;
      if (dy < 0) c.yz = -c.yz, c.xy = -c.xy;
      pairs.insert(pairs.end(), {c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, -c.xz, -c.yz, c.zz});
    }
  return pairs;
}

TEST(PadStep, HasTheSameBitsByATableOfAllPairs) {
  const Bowls all(20, 14);
  PadStepper<float> steps = all.steps(executor());
  PadStepper<float> by_pairs(executor(), all.pad, all.count, all.friction, {.cells = 8, .cell = 0.14}, pairs_of(all));
  by_pairs.set_heights(std::span<const double>(all.heights));
  const std::vector<double> P = pressed(steps, all);
  pressed(by_pairs, all);
  for (int k = 4; k < 12; ++k) {
    if (k < 8)
      steps.move(all.pose(k)), by_pairs.move(all.pose(k));
    else
      steps.press(all.wrench(k, P, 1.1)), by_pairs.press(all.wrench(k, P, 1.1));
    for (std::size_t c = 0; c < all.count; ++c) ASSERT_EQ(rows_of(by_pairs, c), rows_of(steps, c)) << k << " " << c;
  }
}

/// Cells that are softer to themselves in the table, as corners of a pad are, give what a cover that adds as much
/// gives.
TEST(PadStep, DividesRowsByEachCellsOwnInfluence) {
  const Bowls all(20, 15);
  PairInfluence pairs = pairs_of(all);
  std::vector<double> cover(all.heights.size(), 1);
  const double normal = pairs[8], along = std::max(pairs[0], pairs[4]);
  for (std::size_t i = 0; i < 64; i += 3) {
    const std::size_t own = 9 * (65 * i);
    pairs[own] += 1.7 * along, pairs[own + 4] += 1.7 * along, pairs[own + 8] += 1.7 * normal;
    for (std::size_t c = 0; c < all.count; ++c) cover[64 * c + i] = 1 / 2.7;
  }
  const StepOptions options{.cells = 8, .cell = 0.14, .tolerance = 1e-5};
  PadStepper<float> steps = all.steps(executor(), options);
  steps.set_heights(std::span<const double>(all.heights), std::span<const double>(cover));
  PadStepper<float> by_pairs(executor(), all.pad, all.count, all.friction, options, pairs);
  by_pairs.set_heights(std::span<const double>(all.heights));
  for (int k = 0; k < 12; ++k) {
    steps.move(all.pose(k)), by_pairs.move(all.pose(k));
    for (std::size_t c = 0; c < all.count; ++c) {
      const double P = number(steps, c, STEP_RESULT_P);
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(number(by_pairs, c, row), number(steps, c, row), 1e-4 * P) << k << " " << c;  // tolerance of sweeps
      EXPECT_LE(number(by_pairs, c, STEP_RESULT_SWEEPS), 60);
    }
  }
}

TEST(PadStep, SaysWhatItDoesNotServe) {
  const auto made = [](const StepOptions& options, std::span<const double> friction) {
    PadStepper<float>(executor(), rubber, 3, friction, options);
  };
  const std::array one{0.5};
  EXPECT_THROW(made({.cells = 3}, one), ValueError);
  EXPECT_THROW(made({.cell = 0}, one), ValueError);
  EXPECT_THROW(made({.tolerance = -1}, one), ValueError);
  EXPECT_THROW(made({.object_young = -1}, one), ValueError);
  EXPECT_THROW(made({.object_young = std::nan("")}, one), ValueError);
  EXPECT_THROW(made({.object_young = 1, .object_poisson = 0.6}, one), ValueError);
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

/// A face over all of a block of 19 x 19 x 4.5 mm, nu 0.48, mu 0.5, E = 1 MPa.
fem::PadSensor block() {
  fem::PadSensor pad;
  pad.tactels = {4, 4}, pad.pitch = {4.7, 4.7};
  pad.length = pad.width = 19, pad.thickness = 4.5, pad.young = 1, pad.poisson = 0.48;
  return pad;
}
constexpr std::array<std::array<double, 4>, 5> face_way{
    {{0.05, 0, 0, 0}, {0.1, 0, 0, 0}, {0.1, 0.1, 0, 0.005}, {0.1, 0.2, 0, 0.01}, {0.1, 0.3, 0.05, 0.02}}};

// Of an independent program, by 8 x 8 cells with a side kernel of 8 cells of its own; the one of 12 cells differs from
// finer ones by 0.7 % in P and 0.004 in S, so that these may differ by twice that.
TEST(PadStepSides, AFaceOverAllOfThePad) {
  constexpr std::array P{20.62808051, 20.11835539, 18.82483349, 16.87338329},
      S{0.0, 0.27636217, 0.55423340, 0.81888561}, Qx{0.0, 2.41481736, 4.56386817, 5.84429384};
  PadStepper<double> steps(executor(), block(), 1, std::array{0.5}, {.cells = 8, .cell = 19.0 / 8, .tolerance = 1e-5});
  const std::vector<double> heights(64, 0.0);
  steps.set_heights(std::span<const double>(heights));
  for (std::size_t k = 0; k < face_way.size(); ++k) {
    steps.move(face_way[k]);
    if (k == 0) continue;
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_P) / P[k - 1], 1, 0.014) << k;
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_P + 1), Qx[k - 1], 0.014 * P[k - 1]) << k;
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_S), S[k - 1], 0.01) << k;
  }
}

/// A face that slides on keeps its tractions: all cells slip as it moves. Of 8 x 8 cells the rms distance from the
/// middle is sqrt((8 8 - 1) / 6) of them.
TEST(PadStepSides, AFaceThatSlidesHasTheMeanSlideOfItsMotion) {
  PadStepper<double> steps(executor(), block(), 1, std::array{0.1}, {.cells = 8, .cell = 19.0 / 8, .tolerance = 1e-6});
  const std::vector<double> heights(64, 0.0);
  steps.set_heights(std::span<const double>(heights));
  for (const double x : {0.0, 1.0, 2.0, 3.0}) steps.move(std::array{0.1, x, 0.5 * x, 0.0});
  EXPECT_EQ(number(steps, 0, STEP_RESULT_STICK), 0);
  EXPECT_NEAR(number(steps, 0, STEP_RESULT_MEAN), 1, 1e-3);
  EXPECT_NEAR(number(steps, 0, STEP_RESULT_MEAN + 1), 0.5, 1e-3);
  EXPECT_NEAR(number(steps, 0, STEP_RESULT_MEAN + 2), 0, 1e-3);
  steps.reset();
  for (const double turn : {0.0, 0.1, 0.2, 0.3}) steps.move(std::array{0.1, 0.0, 0.0, turn});
  EXPECT_EQ(number(steps, 0, STEP_RESULT_STICK), 0);
  EXPECT_NEAR(number(steps, 0, STEP_RESULT_MEAN), 0, 1e-3);
  EXPECT_NEAR(number(steps, 0, STEP_RESULT_MEAN + 2) / (0.1 * 19.0 / 8 * std::sqrt(63 / 6.0)), 1, 2e-3);
}

TEST(PadStepSides, AreThoseOfTheTwin) {
  const fem::PadSensor pad = block();
  const fem::PadCells cells = fem::fixed_cells(8, 19.0 / 8);
  fem::SteppedContact twin(fem::pad_layer(pad.poisson), pad, cells, 0.5, {.cells = 8, .tolerance = 1e-6});
  twin.set_surface({Eigen::ArrayXd::Zero(64), Eigen::ArrayXd::Ones(64)});
  PadStepper<float> steps(executor(), pad, 17, std::array{0.5}, {.cells = 8, .cell = 19.0 / 8, .tolerance = 1e-5});
  const std::vector<double> heights(17 * std::size_t{64}, 0.0);
  steps.set_heights(std::span<const double>(heights));
  std::vector<double> slid;  // mm, by step
  for (const auto& [depth, x, y, twist] : face_way) {
    std::vector<double> pose;
    for (int c = 0; c < 17; ++c) pose.insert(pose.end(), {depth, x, y, twist});
    steps.move(pose);
    const fem::SteppedState state = twin.move(depth, {x, y, twist});
    for (std::size_t c : {0u, 16u}) {
      for (int row = 0; row < 4; ++row)
        EXPECT_NEAR(number(steps, c, STEP_RESULT_P + row), state.force[row],
                    2e-4 * state.force[0] * (row == 3 ? 9.5 : 1));
      EXPECT_NEAR(number(steps, c, STEP_RESULT_SLID), state.slid, 2e-4);
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(number(steps, c, STEP_RESULT_MEAN + axis), state.mean[axis], 2e-4);
    }
    slid.push_back(state.slid);
  }
  EXPECT_GT(slid[2], 1e-3);  // at the rim, in a way of 0.1 mm
  EXPECT_GT(slid.back(), 5 * slid[2]);
}

// The force on the base is that on the face.
TEST(PadStepSides, FramesSumToTheForceAsTactelsGetFine) {
  for (const auto& [along, within] :
       {std::pair{38, 0.035}, std::pair{76, 0.02}}) {  // stress is singular at the base's corner
    fem::PadSensor pad = block();
    const double pitch = 19.0 / along;
    pad.tactels = {along, along}, pad.pitch = {pitch, pitch};
    PadStepper<float> steps(executor(), pad, 1, std::array{0.5}, {.cells = 8, .cell = 19.0 / 8});
    const std::vector<double> heights(64, 0.0);
    steps.set_heights(std::span<const double>(heights));
    for (const auto& pose : face_way) steps.move(pose);
    const std::span<const float> frames = steps.frames();
    double normal = 0, drag = 0;
    const int count = along * along;
    for (int k = 0; k < count; ++k) normal -= pitch * pitch * frames[k], drag += pitch * pitch * frames[count + k];
    EXPECT_NEAR(normal / number(steps, 0, STEP_RESULT_P), 1, within);
    EXPECT_NEAR(drag / number(steps, 0, STEP_RESULT_P + 1), 1, within);
  }
}

}  // namespace tactel::host::pad_step_test
