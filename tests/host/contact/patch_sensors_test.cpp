// SPDX-License-Identifier: Apache-2.0

// Contacts that each have a sensor of their own: the kernel against the twin of its tables, against the model of each
// sensor, against itself in other lanes, orders and batches, and against laws of scale.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "fem/layer/patch_solver.h"
#include "fem/numbers/value_error.h"
#include "host/answers/planner.h"
#include "host/contact/contact_model.h"
#include "host/contact/lines/contact_fallback.h"
#include "host/contact/lines/patch_contact.h"
#include "host/contact/lines/sensor_tables.h"
#include "tests/fem/expect_error.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/contact/one_launch.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::patch_sensors_test {

using tactel::tests::random_force_scenes;
using tactel::tests::random_scenes;

constexpr fem::SensorRange range{.poisson_low = 0.3, .poisson_high = 0.499, .longest = 14};

const fem::SensorFamily& family() {
  static const fem::SensorFamily family(range);
  return family;
}

/// Scenes by depth or by force, each scaled to a random sensor of the family.
std::vector<fem::Scene> scenes_on_sensors(std::size_t count, std::uint64_t seed, bool force = false) {
  const fem::Sensor usual;
  auto scenes = force ? random_force_scenes(usual, count, seed) : random_scenes(usual, count, seed);
  std::mt19937_64 generator(seed);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(generator); };
  for (fem::Scene& scene : scenes) {
    fem::Sensor& sensor = scene.sensor;
    sensor.poisson = uniform(range.poisson_low, range.poisson_high);
    sensor.thickness = uniform(1, 2);
    sensor.young = uniform(0.5, 4);
    sensor.length = sensor.thickness * uniform(8, 14);
    scene.indenter.position *= sensor.length / usual.length;
  }
  return scenes;
}

template <class Real>
std::vector<fem::ContactSolution> solutions(const PatchContact<Real>& contact, std::span<const fem::Scene> scenes,
                                            std::size_t largest_chunk = 4096) {
  const auto batch = tactel::tests::ran(contact, scenes, largest_chunk);
  std::vector<fem::ContactSolution> all;
  for (std::size_t i = 0; i < scenes.size(); ++i) all.push_back(batch.solution(i));
  return all;
}

struct Difference {
  double slip_index = 0, force = 0, stress = 0;  ///< of S; of P and Q over P; of sigma_y and tau_xy over the largest
};

Difference difference(const fem::ContactSolution& a, const fem::ContactSolution& b) {
  Difference most;
  for (std::size_t k = 0; k < std::min(a.steps.size(), b.steps.size()); ++k) {
    const fem::ContactStep &p = a.steps[k], &q = b.steps[k];
    if (!p.converged || !q.converged || !p.slip_index || !q.slip_index) break;
    most.slip_index = std::max(most.slip_index, std::abs(*p.slip_index - *q.slip_index));
    most.force = std::max({most.force, std::abs(p.P - q.P) / q.P, std::abs(p.Q - q.Q) / q.P});
    const double largest = q.sigma_y.cwiseAbs().maxCoeff();
    most.stress = std::max({most.stress, (p.sigma_y - q.sigma_y).cwiseAbs().maxCoeff() / largest,
                            (p.tau_xy - q.tau_xy).cwiseAbs().maxCoeff() / largest});
  }
  return most;
}

bool same_bits(const fem::ContactSolution& a, const fem::ContactSolution& b) {
  const auto same = [](const fem::ContactStep& p, const fem::ContactStep& q) {
    return p.P == q.P && p.Q == q.Q && p.slip_index == q.slip_index && p.iterations == q.iterations &&
           p.normal_force == q.normal_force && p.tangential_force == q.tangential_force && p.sigma_y == q.sigma_y &&
           p.tau_xy == q.tau_xy;
  };
  return a.surface_x == b.surface_x && std::ranges::equal(a.steps, b.steps, same);
}

class SensorsTwin : public ::testing::TestWithParam<int> {};

template <class Real>
void expect_twin(int elements, bool force, double tolerance) {
  const auto scenes = scenes_on_sensors(40, elements, force);
  const double sweeps_to = !force ? 1e-3 : sizeof(Real) == 8 ? 1e-11 : 1e-5;
  const PatchContact<Real> contact(executor(), family(),
                                   {.elements = elements, .tolerance = sweeps_to, .accept = 2e-2, .most_sweeps = 2000});
  const auto found = solutions(contact, scenes);
  std::size_t solved = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::LayerModel model = family().model(scenes[i].sensor);
    const fem::ContactSolution expected =
        fem::PatchSolver(
            model,
            {.elements = elements, .tolerance = sweeps_to, .accept = 2e-2, .most_sweeps = 2000, .most_growths = 0})
            .solve(scenes[i]);
    ASSERT_EQ(found[i].steps.size(), expected.steps.size()) << i;
    solved += found[i].steps.back().converged;
    const Difference off = difference(found[i], expected);
    EXPECT_LE(std::max({off.slip_index, off.force, off.stress}), tolerance) << "scene " << i;
  }
  EXPECT_GE(solved, scenes.size() * 8 / 10);
}

TEST_P(SensorsTwin, Fp64MatchesIt) {
  expect_twin<double>(GetParam(), false, 1e-9);
  expect_twin<double>(GetParam(), true, 1e-8);
}
INSTANTIATE_TEST_SUITE_P(PatchSensors, SensorsTwin, ::testing::Values(12));
INSTANTIATE_TEST_SUITE_P(Nightly, SensorsTwin, ::testing::Values(8, 16, 24));

class SensorsTwinInFp32 : public SensorsTwin {};
TEST_P(SensorsTwinInFp32, MatchesIt) { expect_twin<float>(GetParam(), false, 1e-4); }
INSTANTIATE_TEST_SUITE_P(PatchSensors, SensorsTwinInFp32, ::testing::Values(8));
INSTANTIATE_TEST_SUITE_P(Nightly, SensorsTwinInFp32, ::testing::Values(12, 16, 24));

TEST(PatchSensorsNightly, AgreeWithTheModelOfEachSensor) {
  auto scenes = scenes_on_sensors(24, 3);
  const auto found = solutions(PatchContact<double>(executor(), family(), {.tolerance = 1e-9}), scenes);
  std::vector<double> slip, force, stress;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::LayerModel own = fem::layer_model(scenes[i].sensor);
    const Difference off =
        difference(found[i], fem::PatchSolver(own, {.tolerance = 1e-9, .most_growths = 0}).solve(scenes[i]));
    slip.push_back(off.slip_index), force.push_back(off.force), stress.push_back(off.stress);
  }
  for (auto* list : {&slip, &force, &stress}) std::ranges::sort(*list);
  EXPECT_LT(slip[12], 1e-4);
  EXPECT_LT(slip.back(), 5e-3);
  EXPECT_LT(force[12], 2e-4);
  EXPECT_LT(stress[12], 4e-3);
  EXPECT_LT(stress.back(), 3e-2);
}

TEST(PatchSensors, BitsDoNotDependOnLanesOrderOrBatch) {
  const auto scenes = scenes_on_sensors(70, 11);
  const PatchContact<float> contact(executor(), family());
  const auto together = solutions(contact, scenes);
  const auto in_chunks = solutions(contact, scenes, 16);
  std::vector<std::size_t> order(scenes.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(2));
  std::vector<fem::Scene> shuffled;
  for (const std::size_t i : order) shuffled.push_back(scenes[i]);
  const auto mixed = solutions(contact, shuffled);
  Executor one_thread{Device(), {.threads = 1}};
  const auto slowly = solutions(PatchContact<float>(one_thread, family()), scenes);
  for (std::size_t k = 0; k < order.size(); ++k) {
    EXPECT_TRUE(same_bits(together[order[k]], mixed[k])) << k;
    EXPECT_TRUE(same_bits(together[k], in_chunks[k])) << k;
    EXPECT_TRUE(same_bits(together[k], slowly[k])) << k;
  }
  for (const std::size_t i : {0UL, 33UL, 69UL})
    EXPECT_TRUE(same_bits(together[i], solutions(contact, std::span(&scenes[i], 1))[0])) << i;
}

TEST(PatchSensors, ForcesAndStressesAreProportionalToE) {
  auto scenes = scenes_on_sensors(20, 17);
  const PatchContact<float> contact(executor(), family());
  for (fem::Scene& scene : scenes) scene.sensor.young = 1;
  const auto soft = solutions(contact, scenes);
  for (fem::Scene& scene : scenes) scene.sensor.young = 4;
  const auto hard = solutions(contact, scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (std::size_t k = 0; k < soft[i].steps.size(); ++k) {
      EXPECT_EQ(4 * soft[i].steps[k].P, hard[i].steps[k].P);
      EXPECT_EQ(4 * soft[i].steps[k].Q, hard[i].steps[k].Q);
      EXPECT_EQ(soft[i].steps[k].slip_index, hard[i].steps[k].slip_index);
      EXPECT_EQ(4 * soft[i].steps[k].sigma_y, hard[i].steps[k].sigma_y);
    }
}

/// Every length twice as long: forces too, stresses and S as they were.
TEST(PatchSensors, AnswersGrowWithAllLengths) {
  auto scenes = scenes_on_sensors(20, 19);
  for (fem::Scene& scene : scenes) {
    scene.indenter.shape = fem::Parabola{10};
    scene.load.indentation = {0.05 * scene.sensor.thickness};
  }
  const PatchContact<double> contact(executor(), family());
  const auto small = solutions(contact, scenes);
  for (fem::Scene& scene : scenes) {
    scene.indenter.shape = fem::Parabola{20};
    scene.indenter.position *= 2;
    scene.sensor.length *= 2, scene.sensor.thickness *= 2;
    for (double& depth : scene.load.indentation) depth *= 2;
    for (double& x : scene.load.tangential) x *= 2;
    scene.load.tangential_step *= 2;
  }
  const auto large = solutions(contact, scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (std::size_t k = 0; k < small[i].steps.size(); ++k) {
      const fem::ContactStep &a = small[i].steps[k], &b = large[i].steps[k];
      EXPECT_NEAR(2 * a.P, b.P, 1e-9 * b.P);
      ASSERT_EQ(a.slip_index.has_value(), b.slip_index.has_value());
      EXPECT_NEAR(a.slip_index.value_or(0), b.slip_index.value_or(0), 1e-9);
      EXPECT_LT((a.sigma_y - b.sigma_y).cwiseAbs().maxCoeff(), 1e-9 * a.sigma_y.cwiseAbs().maxCoeff());
    }
}

/// Two thirds of the shortest sensor's half length from its ends, 5.6 thicknesses: what the ends change falls by
/// e^-0.75 each on the way there and on the way back.
TEST(PatchSensors, LengthDoesNotMatterFarFromTheEnds) {
  std::vector<fem::Scene> scenes = scenes_on_sensors(20, 23);
  for (fem::Scene& scene : scenes) {
    scene.indenter = {fem::Parabola{10}, 0};
    scene.load.indentation = {0.03 * scene.sensor.thickness};
    scene.sensor.length = 11.5 * scene.sensor.thickness;
  }
  const PatchContact<double> contact(executor(), family());
  const auto shorter = solutions(contact, scenes);
  for (fem::Scene& scene : scenes) scene.sensor.length = 14 * scene.sensor.thickness;
  const auto longer = solutions(contact, scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (std::size_t k = 0; k < shorter[i].steps.size(); ++k) {
      EXPECT_NEAR(shorter[i].steps[k].P, longer[i].steps[k].P, 5e-4 * longer[i].steps[k].P);
      EXPECT_NEAR(shorter[i].steps[k].slip_index.value_or(0), longer[i].steps[k].slip_index.value_or(0), 5e-4);
    }
}

void expect_refused(const fem::Sensor& sensor, const std::string& key) {
  fem::Scene scene{.sensor = sensor};
  const PatchContact<float> contact(executor(), family());
  expect_value_error([&] { contact.prepare(std::span(&scene, 1)); }, key, "", "");
}

TEST(PatchSensors, OutsideTheFamilyAreRefused) {
  const auto sensor = [](auto change) {
    fem::Sensor sensor;
    change(sensor);
    return sensor;
  };
  expect_refused(sensor([](auto& s) { s.poisson = 0.25; }), "sensor.poisson");
  expect_refused(sensor([](auto& s) { s.length = 8; }), "sensor.length");
  expect_refused(sensor([](auto& s) { s.length = 22; }), "sensor.length");
  expect_refused(sensor([](auto& s) { s.tactel_width = 0.5; }), "sensor.tactel_width");
  expect_refused(sensor([](auto& s) { s.tactels = 11; }), "sensor.tactels");
  EXPECT_THROW(fem::SensorFamily({.poisson_low = 0.4, .poisson_high = 0.5}), ValueError);
  EXPECT_THROW(fem::SensorFamily({.poisson_low = 0.4, .poisson_high = 0.3}), ValueError);
  EXPECT_THROW(fem::SensorFamily({.longest = 5}), ValueError);
}

TEST(PatchSensors, AFamilyOfOnePoissonIsItsSensor) {
  const fem::SensorFamily one({.poisson_low = 0.45, .poisson_high = 0.45, .longest = 14});
  const auto scenes = random_scenes(fem::Sensor(), 20, 5);
  const auto found = solutions(PatchContact<double>(executor(), one), scenes);
  const auto expected = solutions(PatchContact<double>(executor(), fem::layer_model(fem::Sensor())), scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Difference off = difference(found[i], expected[i]);
    EXPECT_LT(off.slip_index, 2e-3) << i;
    EXPECT_LT(off.force, 2e-3) << i;
    EXPECT_LT(off.stress, 1e-2) << i;
  }
}

/// As sets solve them: no condensation for each sensor.
TEST(PatchSensors, ThePlannerTriesThemOnTheirFamily) {
  const auto scenes = scenes_on_sensors(4, 5);
  const auto contact = [&](std::uint64_t k) { return scenes[k]; };
  const RungChoice chosen = plan_for_many(executor(), 0.9, {scenes.size(), contact, range});
  const PatchContact<float> launcher(executor(), sensor_family(executor(), range),
                                     std::get<PatchModel>(model_of(chosen.rung).surface).options);
  const auto expected = solve_patch_contact(launcher, scenes);
  ASSERT_EQ(chosen.answers.size(), scenes.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) EXPECT_TRUE(same_bits(chosen.answers[i], expected[i])) << i;
  EXPECT_TRUE(chosen.kept);
}

}  // namespace tactel::host::patch_sensors_test
