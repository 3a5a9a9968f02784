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

#include "fem/pad/pad_mix.h"
#include "host/contact/pad_contact.h"
#include "kernels/shared/pad_layout.h"
#include "kernels/shared/pad_step_layout.h"
#include "tests/host/device/test_device.h"

namespace tactel::host {
namespace {

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

}  // namespace
}  // namespace tactel::host
