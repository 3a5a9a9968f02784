// SPDX-License-Identifier: Apache-2.0

// The pad kernel against its twin, against the totals of an independent program, and against itself in other lanes,
// orders, vectors and batches.
#include "host/contact/pads/pad_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "host/contact/pads/pad_contact_tables.h"
#include "host/contact/pads/pad_stream.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"
#include "tests/fem/pad/named_pad_scenes.h"
#include "tests/host/contact/pad_launch.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::pad_contact_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

fem::PadSensor sensor_of(double poisson) {
  return {.tactels = {4, 5}, .pitch = {1.5, 1.2}, .thickness = 2, .young = 1.5, .poisson = poisson};
}

std::vector<fem::PadScene> mix(const fem::PadSensor& sensor, std::size_t count, unsigned seed) {
  fem::PadMix draw(seed, &sensor);
  std::vector<fem::PadScene> scenes(count);
  for (fem::PadScene& scene : scenes) scene = draw();
  return scenes;
}

template <class Real>
void expect_named_scenes(double near, double near_S) {
  for (const fem::NamedScene& named : fem::named_scenes()) {
    const PadContact<Real> contact(
        executor(),
        {.cells = 16, .tolerance = sizeof(Real) == 4 ? 1e-5 : 1e-8, .pressing_increments = 2, .limit_increments = 0});
    const fem::PadSolution solution = ran(contact, std::span(&named.scene, 1), std::vector{named.cells()}).solution(0);
    ASSERT_EQ(solution.steps.size(), named.steps.size());
    for (std::size_t k = 0; k < named.steps.size(); ++k) {
      const auto& [P, Qx, Qy, M, S, stick, touch] = named.steps[k];
      if (P == 0) continue;  // not stated
      const fem::PadStep& step = solution.steps[k];
      EXPECT_NEAR(step.P, P, near) << named.name << k;
      EXPECT_NEAR(step.Q[0], Qx, near) << named.name << k;
      EXPECT_NEAR(step.Q[1], Qy, near) << named.name << k;
      EXPECT_NEAR(step.M, M, near) << named.name << k;
      EXPECT_NEAR(*step.slip_index, S, near_S) << named.name << k;
    }
    for (std::size_t k = 0; k < named.stress.size(); ++k)
      EXPECT_NEAR(solution.steps.back().stress(k < 3 ? 4 : 8, k % 3), named.stress[k], 1e-4) << named.name << k;
  }
}

TEST(PadContact, NamedScenesInFp32) { expect_named_scenes<float>(2e-4, 2e-4); }

TEST(PadContact, NamedScenesInFp64) { expect_named_scenes<double>(2e-5, 2e-4); }  // S: four rounds of the margin

/// Differences of the kernel from the twin on the same cells, largest of the steps of each scene.
struct Difference {
  std::vector<double> S, P, Q, M, stress, slid;
};

template <class Real>
Difference from_twin(int cells, const fem::PadSensor& sensor, std::size_t count, double tolerance,
                     double twin_tolerance, double longer = 1) {
  auto scenes = mix(sensor, count, static_cast<unsigned>(cells));
  for (fem::PadScene& scene : scenes)
    for (auto& drag : scene.load.drags)
      for (double& number : drag) number *= longer;
  const PadContact<Real> contact(executor(), {.cells = cells, .tolerance = tolerance});
  const auto batch = ran(contact, scenes);
  fem::PadOptions options;
  options.cells = cells, options.tolerance = twin_tolerance;
  const fem::PadSolver twin(*contact.layer({sensor.poisson}), options);
  Difference d;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution a = batch.solution(i), b = twin.solve_on(batch.cells(i), batch.scene(i));
    double S = 0, P = 0, Q = 0, M = 0, stress = 0, most_stress = 0, slid = 0;
    for (std::size_t k = 0; k < b.steps.size(); ++k) {
      const fem::PadStep &p = a.steps[k], &q = b.steps[k];
      EXPECT_TRUE(p.converged) << i << " " << k << ": " << p.residual.largest();
      const double force = scenes[i].friction * q.P, size = b.cells.half_size();
      S = std::max(S, std::abs(*p.slip_index - *q.slip_index));
      P = std::max(P, std::abs(p.P / q.P - 1));
      Q = std::max(Q, (p.Q - q.Q).norm() / force);
      M = std::max(M, std::abs(p.M - q.M) / (force * size));
      slid = std::max(slid, std::abs(p.slid - q.slid) / std::max(q.slid, 0.01 * q.indentation));
      // The cells' ways have no sign: what the tolerance leaves of sixteen increments adds up where all stick, too.
      slid = std::max(slid, std::abs(p.slip_path - q.slip_path) / std::max(q.slip_path, q.indentation));
      stress = std::max(stress, (p.stress - q.stress).cwiseAbs().maxCoeff());
      most_stress = std::max(most_stress, q.stress.cwiseAbs().maxCoeff());
    }
    d.S.push_back(S), d.P.push_back(P), d.Q.push_back(Q), d.M.push_back(M), d.stress.push_back(stress / most_stress);
    d.slid.push_back(slid);
  }
  for (auto* v : {&d.S, &d.P, &d.Q, &d.M, &d.stress, &d.slid}) std::sort(v->begin(), v->end());
  return d;
}

class PadTwin : public testing::TestWithParam<std::tuple<int, double>> {};

TEST_P(PadTwin, AgreesInFp32) {
  const auto [cells, poisson] = GetParam();
  const Difference d = from_twin<float>(cells, sensor_of(poisson), cells == 16 ? 18 : 54, 1e-3, 1e-7);
  // What the tolerance of the sweeps leaves: a tenth of it in the middle; arithmetic is below.
  EXPECT_LE(d.S[d.S.size() / 2], 2e-4);
  EXPECT_LE(d.S.back(), 2e-3);
  EXPECT_LE(d.P.back(), 1e-3);
  EXPECT_LE(d.Q.back(), 3e-3);
  EXPECT_LE(d.M.back(), 3e-3);
  EXPECT_LE(d.stress.back(), 2e-3);
  EXPECT_LE(d.slid.back(), 1e-2);  // it adds up what the tolerance leaves of each increment
}

TEST(PadContact, TakesTheSubstepsOfItsTwin) {
  const Difference d = from_twin<float>(8, sensor_of(0.5), 27, 1e-3, 1e-7, 4);
  // As in AgreesInFp32.
  EXPECT_LE(d.S.back(), 2e-3);
  EXPECT_LE(d.Q.back(), 3e-3);
  EXPECT_LE(d.M.back(), 3e-3);
}

TEST(PadContact, AgreesWithItsTwinInFp64) {
  ASSERT_TRUE(executor().device().info().fp64);
  for (const double poisson : {0.3, 0.5}) {
    const Difference d = from_twin<double>(8, sensor_of(poisson), 36, 1e-8, 1e-8);
    EXPECT_LE(d.S.back(), 1e-3);  // four rounds of the margin
    EXPECT_LE(d.P.back(), 1e-9);
    EXPECT_LE(d.Q.back(), 1e-9);
    EXPECT_LE(d.M.back(), 1e-9);
    EXPECT_LE(d.slid.back(), 1e-7);
    EXPECT_LE(d.stress.back(), 1e-3);  // four Gauss points a cell, and quadratics
  }
}

INSTANTIATE_TEST_SUITE_P(CellsAndPoissons, PadTwin,
                         testing::Combine(testing::Values(8, 12, 16), testing::Values(0.3, 0.5)));

/// All numbers of a scene's answer.
template <class Real>
std::vector<double> numbers(const typename PadContact<Real>::Batch& batch, std::size_t i, std::size_t steps) {
  std::vector<double> all;
  const fem::PadSolution solution = batch.solution(i);
  for (std::size_t k = 0; k < steps; ++k) {
    for (int row = 0; row < PAD_RESULT_ROWS; ++row) all.push_back(batch.result(i, static_cast<int>(k), row));
    const fem::PadStep& step = solution.steps[k];
    all.insert(all.end(), step.normal_force.data(), step.normal_force.data() + step.normal_force.size());
    all.insert(all.end(), step.stress.data(), step.stress.data() + step.stress.size());
  }
  return all;
}

TEST(PadContact, SameBitsInAnyOrderBatchAndVector) {
  const fem::PadSensor sensor = sensor_of(0.45);
  auto scenes = mix(sensor, 150, 4);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (i % 5 == 2) scenes[i].load.drags.resize(i % 8);  // paths of other lengths beside them
  const PadContact<float> contact(executor(), {.cells = 8, .vectors = 1});
  const auto batch = ran(contact, scenes);
  std::vector<std::size_t> order(scenes.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  std::vector<fem::PadScene> shuffled;
  shuffled.reserve(order.size());
  for (const std::size_t i : order) shuffled.push_back(scenes[i]);
  for (const int vectors : {1, 2, 3}) {
    const auto other = ran(PadContact<float>(executor(), {.cells = 8, .vectors = vectors}), shuffled);
    for (std::size_t k = 0; k < order.size(); ++k) {
      const std::size_t steps = fem::pad_targets(shuffled[k].load).size();
      ASSERT_EQ(numbers<float>(other, k, steps), numbers<float>(batch, order[k], steps)) << vectors << " " << k;
    }
  }
  for (const std::size_t i : {0u, 17u, 149u})
    EXPECT_EQ(numbers<float>(ran(contact, std::span(&scenes[i], 1)), 0, 1), numbers<float>(batch, i, 1)) << i;
}

TEST(PadContact, ThreadsDoNotChangeBits) {
  const auto scenes = mix(sensor_of(0.45), 60, 5);
  Executor one{Device(), {.threads = 1}};
  const auto a = ran(PadContact<float>(executor(), {.cells = 8}), scenes),
             b = ran(PadContact<float>(one, {.cells = 8}), scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) EXPECT_EQ(numbers<float>(a, i, 9), numbers<float>(b, i, 9)) << i;
}

TEST(PadContact, VectorsInHalvesDoNotChangeBits) {
  const auto scenes = mix(sensor_of(0.45), 40, 5);
  Executor whole{Device().with_halves(false)}, halves{Device().with_halves(true)};
  const auto a = ran(PadContact<float>(whole, {.cells = 12}), scenes),
             b = ran(PadContact<float>(halves, {.cells = 12}), scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) EXPECT_EQ(numbers<float>(a, i, 9), numbers<float>(b, i, 9)) << i;
}

/// Scenes of objects each of its own rubber, rigid ones and curved skins among them.
std::vector<fem::PadScene> soft_mix(std::size_t count, unsigned seed) {
  std::vector<fem::PadScene> scenes = mix(sensor_of(0.45), count, seed);
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<double>(i);
    const auto turn = [i](std::size_t of) { return static_cast<double>(i % of); };
    if (i % 5 != 0) scenes[i].indenter.young = 0.1 * std::exp2(k / 3), scenes[i].indenter.poisson = 0.05 * turn(11);
    if (i % 3 == 0) scenes[i].sensor.curvature_radius = 10 + k, scenes[i].indenter.position = {0.1 * turn(7), -0.3};
    if (i % 4 == 1) scenes[i].sensor.poisson = 0.3 + 0.02 * turn(9);
  }
  return scenes;
}

template <class Real>
void expect_twins(const std::vector<fem::PadScene>& scenes, const fem::PadOptions& options, double near) {
  const auto batch = ran(PadContact<Real>(executor(), options), scenes);
  fem::PadOptions exact = options;
  exact.tolerance = std::min(1e-7, options.tolerance);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadLayer layer = fem::pad_layer(scenes[i]);
    const fem::PadSolution a = batch.solution(i),
                           b = fem::PadSolver(layer, exact).solve_on(batch.cells(i), batch.scene(i));
    for (std::size_t k = 0; k < b.steps.size(); ++k) {
      const fem::PadStep &p = a.steps[k], &q = b.steps[k];
      EXPECT_TRUE(p.converged) << i << " " << k << ": " << p.residual.largest();
      EXPECT_NEAR(p.P / q.P, 1, near) << i << " " << k;
      EXPECT_LE((p.Q - q.Q).norm(), 3 * near * scenes[i].friction * q.P) << i << " " << k;
      EXPECT_NEAR(*p.slip_index, *q.slip_index, 1e-3 + near) << i << " " << k;
      EXPECT_LE((p.stress - q.stress).cwiseAbs().maxCoeff(), (1e-3 + near) * q.stress.cwiseAbs().maxCoeff()) << i;
    }
  }
}

TEST(PadContactSoft, AgreesWithItsTwin) {
  expect_twins<double>(soft_mix(36, 8), {.cells = 8, .tolerance = 1e-8}, 1e-8);
  expect_twins<double>(soft_mix(36, 8), {.cells = 8, .tolerance = 1e-8, .any_poisson = true}, 1e-6);
  expect_twins<float>(soft_mix(36, 8), {.cells = 12}, 1e-3);
}

/// Half of the scenes on layers of three kinds, one of a cover that carries shear far.
std::vector<fem::PadScene> layered_mix(std::size_t count, unsigned seed) {
  const std::vector<RubberLayer> kinds[] = {{{1.5, 0.4, 0.3}, {0.5, 2, 0.48}},
                                            {{1.85, 1, 0.48}, {0.15, 10, 0.48}},
                                            {{0.05, 1, 0.49}, {1.9, 1, 0.45}, {0.05, 900, 0.4}}};
  std::vector<fem::PadScene> scenes = soft_mix(count, seed);
  for (std::size_t i = 0; i < count; i += 2) {
    fem::PadSensor& sensor = scenes[i].sensor;
    const double scale = sensor.thickness / 2;
    sensor.layers = kinds[i / 2 % 3];
    for (RubberLayer& layer : sensor.layers) layer.thickness *= scale;
    const fem::PadSensor own = with_layers({.layers = sensor.layers});
    sensor.thickness = own.thickness, sensor.young = own.young, sensor.poisson = own.poisson;
  }
  return scenes;
}

TEST(PadContactLayered, AgreesWithItsTwin) {
  expect_twins<double>(layered_mix(24, 8), {.cells = 8, .tolerance = 1e-8}, 1e-8);
  expect_twins<float>(layered_mix(24, 10), {.cells = 12}, 1e-3);
}

TEST(PadContactSoft, SameBitsInAnyOrderBatchAndThreads) {
  std::vector<fem::PadScene> scenes = soft_mix(50, 9);
  const auto layered = layered_mix(12, 3);
  scenes.insert(scenes.begin() + 7, layered.begin(), layered.end());
  Executor single{Device(), {.threads = 1}};
  const auto batch = ran(PadContact<float>(executor(), {.cells = 8}), scenes);
  std::vector<fem::PadScene> backwards(scenes.rbegin(), scenes.rend());
  const auto other = ran(PadContact<float>(single, {.cells = 8}), backwards);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    ASSERT_EQ(numbers<float>(other, scenes.size() - 1 - i, 9), numbers<float>(batch, i, 9)) << i;
  for (const std::size_t i : {0u, 3u, 17u})
    EXPECT_EQ(numbers<float>(ran(PadContact<float>(executor(), {.cells = 8}), std::span(&scenes[i], 1)), 0, 1),
              numbers<float>(batch, i, 1));
}

TEST(PadContact, ReachesGivenForcesAsItsTwin) {
  const fem::PadSensor sensor = sensor_of(0.45);
  auto scenes = mix(sensor, 27, 6);
  const PadContact<float> contact(executor(), {.cells = 8});
  const auto by_depth = ran(contact, scenes);
  for (std::size_t i = 0; i < scenes.size(); i += 2) {  // beside others by depth
    scenes[i].load.normal_force = {by_depth.result(i, 0, RESULT_P), 0.6 * by_depth.result(i, 0, RESULT_P)};
    scenes[i].load.indentation.clear();
  }
  const auto batch = ran(contact, scenes);
  fem::PadOptions options;
  options.cells = 8, options.tolerance = 1e-6;
  const fem::PadSolver twin(*contact.layer({sensor.poisson}), options);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (i % 2 == 1) {
      EXPECT_EQ(batch.result(i, 3, RESULT_P), by_depth.result(i, 3, RESULT_P)) << i;
      continue;
    }
    const fem::PadSolution a = batch.solution(i), b = twin.solve_on(batch.cells(i), batch.scene(i));
    ASSERT_EQ(a.steps.size(), 10u);
    for (std::size_t k = 0; k < a.steps.size(); ++k) {
      const fem::PadStep &p = a.steps[k], &q = b.steps[k];
      EXPECT_TRUE(p.converged) << i << " " << k << ": " << p.residual.largest();
      EXPECT_NEAR(p.P / q.P, 1, 1.2e-3) << i << " " << k;  // the tolerance of given forces
      EXPECT_NEAR(p.indentation / q.indentation, 1, 2e-3) << i << " " << k;
      EXPECT_NEAR(*p.slip_index, *q.slip_index, 5e-3) << i << " " << k;
    }
  }
}

/// A rounded box that is pressed by a force, twisted and dragged back, as in examples/pad_twist.toml.
template <class Real>
void expect_twists_by_force(double tolerance) {
  std::vector<fem::PadScene> scenes;
  for (const double edge : {0.1, 1.5})
    for (const double force : {0.5, 5.0}) {
      fem::PadScene& scene = scenes.emplace_back();
      scene.sensor = {.thickness = 4, .young = 0.5, .poisson = 0.48};
      scene.indenter = {.shape = fem::Box{{3, 2}, edge}, .yaw = 30};
      scene.load = {.normal_force = {0.4 * force, force},
                    .drags = {{0, 0, 0.05}, {0.1, 0, 0.1}, {0.1, 0.1, 0.1}, {0, 0, 0}}};
    }
  const PadContact<Real> contact(executor(), {.cells = 8, .tolerance = tolerance});
  const auto batch = ran(contact, scenes);
  fem::PadOptions options;
  options.cells = 8, options.tolerance = tolerance / 100;
  const fem::PadSolver twin(*contact.layer({0.48}), options);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution a = batch.solution(i), b = twin.solve_on(batch.cells(i), batch.scene(i));
    for (std::size_t k = 0; k < b.steps.size(); ++k) {
      const fem::PadStep &p = a.steps[k], &q = b.steps[k];
      EXPECT_TRUE(p.converged && q.converged) << i << " " << k;
      EXPECT_NEAR(p.P / q.P, 1, 1.2 * tolerance) << i << " " << k;  // both are asked for the force to their tolerance
      EXPECT_LE((p.Q - q.Q).norm(), 5 * tolerance * q.P) << i << " " << k;
    }
  }
}

TEST(PadContact, TwistsByForceAsItsTwin) {
  expect_twists_by_force<float>(1e-3);
  expect_twists_by_force<double>(1e-7);
}

TEST(PadContact, AnInvalidSceneDoesNotHarmItsNeighbours) {
  fem::PadSensor sensor = sensor_of(0.45);
  std::vector<fem::PadScene> scenes(3);
  for (fem::PadScene& scene : scenes) {
    scene.sensor = sensor;
    scene.load.drags = {{0.02, 0, 0}, {0.04, 0.01, 0.01}};
  }
  const PadContact<float> contact(executor(), {.cells = 8});
  const auto good = ran(contact, scenes);
  const std::vector<fem::PadCells> cells(3, good.cells(0));
  scenes[1].load.drags[0][1] = nan;
  const auto batch = ran(contact, scenes, cells);
  EXPECT_EQ(batch.result(1, 0, RESULT_STATUS), LANE_INVALID);
  EXPECT_EQ(batch.result(1, 2, RESULT_P), 0);
  for (const std::size_t i : {0u, 2u}) EXPECT_EQ(numbers<float>(batch, i, 3), numbers<float>(good, i, 3));
}

TEST(PadContact, SaysOnWhichSidesItsCellsAreTooSmall) {
  fem::PadScene scene;
  scene.load.indentation = {0.25};
  const fem::PadCells cells{.n = 8, .hx = 0.15, .hy = 0.6, .x_middle = 1.2};
  const PadContact<float> contact(executor(), {.cells = 8});
  const fem::PadSolution solution = ran(contact, std::span(&scene, 1), std::span(&cells, 1)).solution(0);
  EXPECT_EQ(solution.outside, (std::array{true, false, false, false}));
  EXPECT_FALSE(solution.steps[0].converged);
}

TEST(PadContact, CellsGrowUntilTheContactLiesInside) {
  std::vector<fem::PadScene> scenes(2);
  for (fem::PadScene& scene : scenes) scene.load.indentation = {0.25};
  const PadContact<float> contact(executor(), {.cells = 8});
  const std::vector<fem::PadCells> cells{{.n = 8, .hx = 0.2, .hy = 0.25}, {.n = 8, .hx = 0.5, .hy = 0.5}};
  const auto solutions = solve_pad_contact(contact, scenes, cells);
  EXPECT_GT(solutions[0].cells.hx, 0.2);
  EXPECT_EQ(solutions[1].cells.hx, 0.5);
  for (const fem::PadSolution& solution : solutions) EXPECT_FALSE(solution.fell_back);
  EXPECT_TRUE(solutions[0].steps[0].converged);
  EXPECT_NEAR(solutions[0].steps[0].P / solutions[1].steps[0].P, 1, 0.04);  // other cells of the same contact
}

TEST(PadContact, TheTwinSolvesWhatTheKernelDoesNot) {
  auto scenes = mix(sensor_of(0.45), 9, 8);
  for (const auto& solution : solve_pad_contact(PadContact<float>(executor(), {.cells = 8, .most_sweeps = 1}),
                                                std::span<const fem::PadScene>(scenes))) {
    EXPECT_TRUE(solution.fell_back);
    EXPECT_TRUE(every_step_converged(solution));
  }
}

TEST(PadContact, TactelsTakeTheMeanOverTheirSquare) {
  fem::PadScene scene;
  scene.sensor.tactel_size = 2.5;
  scene.indenter.position = {0.7, -0.4};
  scene.indenter.yaw = 25;
  scene.load.drags = {{0.05, 0.02, 0}};
  const PadContact<float> contact(executor(), {.cells = 12});
  const auto batch = ran(contact, std::span(&scene, 1));
  const fem::PadStep
      step = batch.solution(0).steps.back(),
      twin = fem::PadSolver(*contact.layer({scene.sensor.poisson})).solve_on(batch.cells(0), scene).steps.back();
  EXPECT_LE((step.stress - twin.stress).cwiseAbs().maxCoeff(), 2e-3 * twin.stress.cwiseAbs().maxCoeff());
}

/// fp32: cells of any size take their influence from those of the ladder's rungs, right to 1e-5 of the largest; to 4e-3
/// where tractions pass over to smooth ones within four rungs.
TEST(PadTables, InfluenceBetweenTheRungsOfTheLadder) {
  constexpr int cells = 8;
  for (const double poisson : {0.3, 0.5}) {
    const PadTables between({poisson}, cells, false), exact({poisson}, cells, true);
    for (const auto& [hx, hy] : {std::pair{0.03, 0.05},
                                 {0.125, 0.3},
                                 {0.31, 0.31},
                                 {0.5, 0.25},
                                 {1.7, 0.9},
                                 {1e-7, 3e-6},
                                 {1.0 / 4096, 2.0},
                                 {std::exp2(-40.25), std::exp2(-40)}}) {
      const PadCellSize size = cell_size({.n = cells, .hx = 3 * hx, .hy = 3 * hy}, 3);
      const auto a = between.influence(size), b = exact.influence(size);
      ASSERT_EQ(a->size(), PAD_TABLE_HEAD + 81u * PAD_OWN_INFLUENCE);
      for (std::size_t k = 0; k < a->size(); ++k)
        ASSERT_NEAR((*a)[k], (*b)[k], (hx == 1.7 ? 4e-3 : 1e-5) * (k < PAD_TABLE_HEAD ? (*b)[k] : 1))
            << poisson << " " << hx << " " << k;
      if (hx == 0.5 || hx < 1e-8) {  // both sides are on rungs
        EXPECT_EQ(*a, *b);
      }
    }
  }
}

}  // namespace tactel::host::pad_contact_test
