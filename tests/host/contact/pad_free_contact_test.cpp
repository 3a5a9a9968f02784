// SPDX-License-Identifier: Apache-2.0

// Contacts on pads with free sides by the kernel: against the twin, and against itself in other lanes and batches.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "fem/pad/pad_layers.h"
#include "host/contact/pads/pad_contact.h"
#include "host/contact/pads/pad_stream.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"
#include "tests/host/contact/pad_launch.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::pad_free_contact_test {

constexpr double L = 19;

struct Named {
  const char* name;
  fem::PadIndenter indenter;
  double depth;  ///< at H = 4.5 mm, in proportion at others
};

std::vector<Named> named() {
  return {{"ball in the middle", {.shape = fem::Sphere{15}, .position = {0.1, 0.2}, .yaw = 20}, 0.6},
          {"ball near the edge", {.shape = fem::Sphere{15}, .position = {5.1, 0.2}}, 0.6},
          {"ball over the edge", {.shape = fem::Sphere{15}, .position = {8.5, 0.2}}, 0.6},
          {"ball at the corner", {.shape = fem::Sphere{15}, .position = {-8, 8}}, 0.6},
          {"face over all", {.shape = fem::Box{{20, 20}, 0}}, 0.1},
          {"face over all, turned", {.shape = fem::Box{{20, 20}, 0}, .yaw = 30}, 0.1},
          {"box corner", {.shape = fem::Box{{10, 10}, 0}, .position = {8.2, 7}, .yaw = 90}, 0.1},
          {"box within, turned", {.shape = fem::Box{{4, 3}, 0}, .position = {1, 1}, .yaw = 30}, 0.1},
          {"oblique box edge", {.shape = fem::Box{{10, 20}, 0}, .position = {8, 0}, .yaw = 28.65}, 0.1},
          {"rounded, tilted box over the edge",
           {.shape = fem::Box{{5, 5}, 1}, .position = {7, 0}, .yaw = 10, .tilt = 0.4, .tilt_direction = 40},
           0.2},
          {"punch over the edge", {.shape = fem::Punch{4, 0}, .position = {7, 0}}, 0.1}};
}

/// A press and drags up to near sliding, some by force; E = 1.5 MPa.
std::vector<fem::PadScene> scenes_on(double H, double poisson) {
  std::vector<fem::PadScene> scenes;
  for (const Named& of : named()) {
    fem::PadScene& scene = scenes.emplace_back();
    scene.sensor = {.tactels = {4, 5},
                    .pitch = {4.5, 3.6},
                    .thickness = H,
                    .young = 1.5,
                    .poisson = poisson,
                    .length = L,
                    .width = L};
    scene.indenter = of.indenter;
    const double depth = of.depth * H / 4.5, way = scene.friction * depth;
    scene.load.indentation = {depth};
    for (const double k : {0.5, 1.0, 1.5}) scene.load.drags.push_back({k * way, 0.2 * k * way, k * k * way / 10});
  }
  for (const std::size_t by_force : {2u, 6u})
    scenes[by_force].load.indentation.clear(), scenes[by_force].load.normal_force = {3, 6};
  return scenes;
}

struct Near {
  double P, S, Q, stress;
};

template <class Real>
void expect_twin(double H, double poisson, int cells, double tolerance, double twin_tolerance, const Near& near,
                 std::optional<double> young = {}) {
  std::vector<fem::PadScene> scenes = scenes_on(H, poisson);
  for (fem::PadScene& scene : scenes) scene.indenter.young = young;
  const PadContact<Real> contact(executor(), {.cells = cells, .tolerance = tolerance});
  const auto batch = ran(contact, scenes);
  const fem::PadLayer layer = fem::pad_layer(scenes[0]);
  const fem::PadSolver twin(layer, {.cells = cells, .tolerance = twin_tolerance});
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::string what =
        std::string(named()[i].name) + ", H " + std::to_string(H) + ", nu " + std::to_string(poisson);
    const fem::PadSolution a = batch.solution(i), b = twin.solve_on(batch.cells(i), batch.scene(i));
    double most_stress = 0;
    for (const fem::PadStep& step : b.steps) most_stress = std::max(most_stress, step.stress.cwiseAbs().maxCoeff());
    for (std::size_t k = 0; k < b.steps.size(); ++k) {
      const fem::PadStep &p = a.steps[k], &q = b.steps[k];
      EXPECT_TRUE(p.converged) << what << " " << k << ": " << p.residual.largest();
      const double force = scenes[i].friction * q.P;
      EXPECT_NEAR(p.P / q.P, 1, near.P + (by_force(scenes[i]) ? 1.2 * tolerance : 0)) << what << " " << k;
      EXPECT_NEAR(*p.slip_index, *q.slip_index, near.S) << what << " " << k;
      EXPECT_LT((p.Q - q.Q).norm() / force, near.Q) << what << " " << k;
      EXPECT_LT(std::abs(p.M - q.M) / (force * b.cells.half_size()), near.Q) << what << " " << k;
      EXPECT_LT((p.stress - q.stress).cwiseAbs().maxCoeff() / most_stress, near.stress) << what << " " << k;
      EXPECT_NEAR(p.area, q.area, 1e-5 * q.area + 3.01 * b.cells.area()) << what << " " << k;
    }
    EXPECT_EQ(a.outside, b.outside) << what;
  }
}

TEST(PadFreeContact, AgreesWithItsTwinInFp32) {
  // What the tolerance leaves; the layer's means lie between sizes on a ladder.
  for (const auto& [H, poisson] : {std::pair{4.5, 0.48}, {2.0, 0.3}, {6.0, 0.4999}})
    expect_twin<float>(H, poisson, 12, 1e-3, 1e-7, {5e-4, 1.5e-3, 2e-3, 2e-3});
  expect_twin<float>(3, 0.45, 8, 1e-3, 1e-7, {5e-4, 1.5e-3, 2e-3, 4e-3});
}

TEST(PadFreeContact, AgreesWithItsTwinInFp64) {
  expect_twin<double>(4.5, 0.48, 8, 1e-7, 1e-8, {1e-6, 1e-3, 1e-6, 1e-3});  // S: four rounds of the margin
}

TEST(PadFreeContact, SoftObjectsAgreeWithTheTwin) {
  expect_twin<double>(4.5, 0.48, 8, 1e-7, 1e-8, {1e-6, 1e-3, 1e-6, 1e-3}, 0.5);
}

/// All numbers of a scene's answer.
std::vector<double> numbers(const PadContact<float>::Batch& batch, std::size_t i) {
  std::vector<double> all;
  const fem::PadSolution solution = batch.solution(i);
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    for (int row = 0; row < PAD_RESULT_ROWS; ++row) all.push_back(batch.result(i, static_cast<int>(k), row));
    const fem::PadStep& step = solution.steps[k];
    all.insert(all.end(), step.normal_force.begin(), step.normal_force.end());
    all.insert(all.end(), step.stress.data(), step.stress.data() + step.stress.size());
  }
  return all;
}

TEST(PadFreeContact, SameBitsInAnyBatchOrderAndVector) {
  const std::vector<fem::PadScene> scenes = scenes_on(4.5, 0.48);
  const PadContact<float> contact(executor(), {.cells = 8});
  const auto batch = ran(contact, scenes);
  std::vector<fem::PadScene> reversed(scenes.rbegin(), scenes.rend());
  for (fem::PadScene& scene : reversed) scene.load.drags.resize(3);
  reversed.erase(reversed.begin() + 3);
  const Device basic("basic");
  for (const Device& device : {basic.with_lanes(2), basic.as_gpu()}) {
    Executor other(device, {.threads = 2});
    const auto again = ran(PadContact<float>(other, {.cells = 8}), reversed);
    const std::size_t last = scenes.size() - 1;
    for (std::size_t k = 0; k < reversed.size(); ++k)
      ASSERT_EQ(numbers(again, k), numbers(batch, last - k - (k >= 3 ? 1 : 0)))
          << device.lanes(Precision::fp32) << " " << k;
  }
}

TEST(PadFreeContact, WhatIsNoSceneDoesNotHarmItsNeighbours) {
  std::vector<fem::PadScene> scenes = scenes_on(4.5, 0.48);
  scenes.resize(3);
  const PadContact<float> contact(executor(), {.cells = 8});
  const auto good = ran(contact, scenes);
  std::vector<fem::PadCells> cells;
  std::vector<fem::PadScene> seen;
  for (std::size_t i = 0; i < 3; ++i) cells.push_back(good.cells(i)), seen.push_back(good.scene(i));
  seen[1].load.drags[0][1] = std::numeric_limits<double>::quiet_NaN();
  auto batch = contact.prepare(seen, cells);
  batch.run();
  EXPECT_EQ(batch.result(1, 0, RESULT_STATUS), LANE_INVALID);
  for (const std::size_t i : {0u, 2u}) EXPECT_EQ(numbers(batch, i), numbers(good, i));
}

TEST(PadFreeContact, OneLaunchHasOneBlock) {
  std::vector<fem::PadScene> scenes = scenes_on(4.5, 0.48);
  scenes[1].sensor.length = 20;
  const PadContact<float> contact(executor(), {.cells = 8});
  EXPECT_THROW(contact.prepare(scenes), std::invalid_argument);
  // The stream makes launches of them.
  const auto solutions = PadStream(executor(), {.options = {.cells = 8}}).solve(scenes);
  EXPECT_TRUE(std::ranges::all_of(solutions, every_step_converged));
}

TEST(PadFreeContact, CellsGrowAndTheTwinSolvesTheRest) {
  std::vector<fem::PadScene> scenes = scenes_on(4.5, 0.48);
  scenes.resize(1);
  const PadContact<float> contact(executor(), {.cells = 8});
  const std::vector<fem::PadCells> small{{.n = 8, .hx = 0.3, .hy = 0.5}};
  const fem::PadSolution grown = solve_pad_contact(contact, scenes, small)[0],
                         fitted = solve_pad_contact(contact, std::span<const fem::PadScene>(scenes))[0];
  EXPECT_GT(grown.cells.hx, 0.3);
  EXPECT_FALSE(grown.fell_back || fitted.fell_back);
  EXPECT_NEAR(grown.steps[0].P / fitted.steps[0].P, 1, 0.04);  // other cells of the same contact
  for (const auto& solution : solve_pad_contact(PadContact<float>(executor(), {.cells = 8, .most_sweeps = 1}),
                                                std::span<const fem::PadScene>(scenes))) {
    EXPECT_TRUE(solution.fell_back);
    EXPECT_TRUE(every_step_converged(solution));
  }
}

TEST(PadFreeContact, ContactsBeyondTheBlockOfALongPadAreNotSolved) {
  std::vector<fem::PadScene> scenes = scenes_on(1.2, 0.48);  // 15.8 H long, of which a contact sees 12
  const auto solutions = PadStream(executor(), {.options = {.cells = 8}}).solve(scenes);
  EXPECT_FALSE(every_step_converged(solutions[4]));  // a face over all
  for (const std::size_t i : {0u, 1u, 2u}) EXPECT_TRUE(every_step_converged(solutions[i])) << i;
}

TEST(PadFreeContact, LongPadsHaveABlockForEachPlace) {
  std::vector<fem::PadScene> scenes = scenes_on(1.5, 0.48);  // 12.7 H long
  scenes.resize(4);
  for (fem::PadScene& scene : scenes) scene.indenter.position[0] /= 2;
  const PadContact<float> contact(executor(), {.cells = 8});
  const auto batch = ran(contact, scenes);
  const fem::PadLayer layer = fem::pad_layer(0.48);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution twin = fem::PadSolver(layer, {.cells = 8}).solve_on(batch.cells(i), batch.scene(i));
    const fem::PadStep a = batch.solution(i).steps.back(), &b = twin.steps.back();
    EXPECT_NEAR(a.P / b.P, 1, 3e-3) << i;
    EXPECT_LT((a.stress - b.stress).cwiseAbs().maxCoeff(), 5e-3 * b.stress.cwiseAbs().maxCoeff()) << i;
  }
}

}  // namespace tactel::host::pad_free_contact_test
