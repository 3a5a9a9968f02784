// SPDX-License-Identifier: Apache-2.0

// The patch kernel against its twin, against itself in other lanes, orders and batches, and against laws that neither
// knows.
#include "host/contact/lines/patch_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "fem/layer/patch_solver.h"
#include "host/contact/lines/contact_fallback.h"
#include "host/contact/lines/contact_stream.h"
#include "kernels/shared/contact_layout.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/contact/one_launch.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::patch_contact_test {

using tactel::tests::all_shapes;
using tactel::tests::hash;
using tactel::tests::hashes;
using tactel::tests::Hashes;
using tactel::tests::ran;
using tactel::tests::random_force_scenes;
using tactel::tests::random_scenes;
using tactel::tests::reversal;

constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();

fem::Sensor sensor_of(double poisson) { return {.poisson = poisson}; }

/// Scenes of every kind: by depth, force and angle, bonded, frictionless, near the ends.
std::vector<fem::Scene> mixed_scenes(const fem::Sensor& sensor, std::size_t count, std::uint64_t seed) {
  auto scenes = random_scenes(sensor, count, seed);
  const auto forces = random_force_scenes(sensor, count, seed);
  scenes.insert(scenes.end(), forces.begin(), forces.end());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (i % 7 == 3) scenes[i].friction = infinity;
    if (i % 5 == 0) scenes[i].friction = 0, scenes[i].load.angle.reset();
    if (i % 9 == 2) scenes[i].indenter.position *= 2.4;
    if (i % 11 == 4 && !by_force(scenes[i])) scenes[i].load.indentation.push_back(0.5 * scenes[i].load.indentation[0]);
  }
  return scenes;
}

std::string describe(const fem::Scene& s) {
  return std::string(fem::shape_name(s.indenter.shape)) + " at " + std::to_string(s.indenter.position) + ", mu " +
         std::to_string(s.friction) + (by_force(s) ? ", by force" : ", by depth");
}

/// Scenes of one kind, in their order.
std::vector<std::vector<fem::Scene>> by_kind(const std::vector<fem::Scene>& scenes) {
  std::vector<std::vector<fem::Scene>> kinds(4);
  for (const fem::Scene& scene : scenes) kinds[2 * kind_of(scene).force + kind_of(scene).friction].push_back(scene);
  return kinds;
}

/// Whether the same steps are solved in both.
bool solved_alike(const fem::ContactSolution& a, const fem::ContactSolution& b) {
  return std::ranges::equal(a.steps, b.steps, {}, &fem::ContactStep::converged, &fem::ContactStep::converged);
}

/// Largest difference of P, Q and base stress, relative; of steps that both solved.
double difference(const fem::ContactSolution& a, const fem::ContactSolution& b) {
  double most = 0;
  for (std::size_t k = 0; k < std::min(a.steps.size(), b.steps.size()); ++k) {
    const fem::ContactStep &p = a.steps[k], &q = b.steps[k];
    if (!p.converged || !q.converged) break;
    const double force = q.P + std::abs(q.Q), stress = q.sigma_y.cwiseAbs().maxCoeff();
    const double off = std::max(std::abs(p.P - q.P), std::abs(p.Q - q.Q)) / (force > 0 ? force : 1);
    const double sigma = (p.sigma_y - q.sigma_y).cwiseAbs().maxCoeff(),
                 tau = (p.tau_xy - q.tau_xy).cwiseAbs().maxCoeff();
    const double of_stress = std::max(sigma, tau) / (stress > 0 ? stress : 1);
    if (!(off <= most)) most = off;
    if (!(of_stress <= most)) most = of_stress;
  }
  return most;
}

/// The kernel's windows come from closed forms, the twin's from bisection; else they make the same steps. fp32 rounds C
/// to 6e-8, and the places of elements under a force to 1e-7.
constexpr double agree_fp64 = 1e-9, agree_fp32 = 3e-5;

class Twin : public ::testing::TestWithParam<int> {};

/// Under forces, rounding decides now and then whether one more trial follows: so the sweeps go further there, and both
/// end in the same solution. Rounding also decides at the edge of what counts as solved.
template <class Real>
void expect_twin(int elements, double poisson, double tolerance) {
  const fem::LayerModel model = fem::layer_model(sensor_of(poisson));
  std::size_t solved = 0, scenes_in_all = 0, not_alike = 0;
  for (const auto& scenes : by_kind(mixed_scenes(model.sensor, 30, elements))) {
    if (scenes.empty()) continue;
    const double sweeps_to = !by_force(scenes.front()) ? 1e-3 : sizeof(Real) == 8 ? 1e-11 : 1e-5;
    const PatchContact<Real> contact(
        executor(), model, {.elements = elements, .tolerance = sweeps_to, .accept = 2e-2, .most_sweeps = 2000});
    const fem::PatchSolver twin(
        model, {.elements = elements, .tolerance = sweeps_to, .accept = 2e-2, .most_sweeps = 2000, .most_growths = 0});
    const auto batch = ran(contact, scenes);
    for (std::size_t i = 0; i < scenes.size(); ++i, ++scenes_in_all) {
      const fem::ContactSolution found = batch.solution(i), expected = twin.solve(scenes[i]);
      solved += found.steps.back().converged;
      not_alike += !solved_alike(found, expected);
      EXPECT_LE(difference(found, expected), tolerance) << describe(scenes[i]) << ", scene " << i;
      EXPECT_NEAR(found.surface_x[0], expected.surface_x[0], 1e-4 * model.sensor.thickness) << describe(scenes[i]);
    }
  }
  EXPECT_GE(solved, 0.8 * static_cast<double>(scenes_in_all));
  EXPECT_LE(not_alike, scenes_in_all / 20);
}

TEST_P(Twin, Fp64MatchesIt) {
  for (const double poisson : {0.3, 0.499}) expect_twin<double>(GetParam(), poisson, agree_fp64);
}
// Of 12 elements are most programs here; another number takes eight more of some two seconds.
INSTANTIATE_TEST_SUITE_P(PatchContact, Twin, ::testing::Values(12));
INSTANTIATE_TEST_SUITE_P(Nightly, Twin, ::testing::Values(8, 16, 24));

class TwinInFp32 : public Twin {};
TEST_P(TwinInFp32, MatchesIt) { expect_twin<float>(GetParam(), 0.45, agree_fp32); }
INSTANTIATE_TEST_SUITE_P(PatchContact, TwinInFp32, ::testing::Values(12));
INSTANTIATE_TEST_SUITE_P(Nightly, TwinInFp32, ::testing::Values(8, 16, 24));

/// Layers change only tables. Those of the kernel have equal cells, the twin's are graded: cubics leave 1e-6 of either.
template <class Real>
void expect_layered_twin(std::vector<RubberLayer> layers, double tolerance) {
  fem::Sensor sensor;
  sensor.layers = std::move(layers);
  sensor = with_layers(sensor);
  const fem::LayerModel model = fem::layer_model(sensor);
  std::size_t solved = 0, scenes_in_all = 0, not_alike = 0;
  for (auto& scenes : by_kind(mixed_scenes(sensor, 8, 5))) {
    for (fem::Scene& scene : scenes) {  // by powers of 2, which leave the proportions of layers as they are
      const double E = std::exp2(std::round(std::log2(scene.sensor.young / sensor.young)));
      for (RubberLayer& layer : scene.sensor.layers) layer.young *= E;
      scene.sensor.young = E * sensor.young;
    }
    if (scenes.empty()) continue;
    const fem::PatchOptions options{.tolerance = 1e-5, .accept = 2e-2, .most_sweeps = 2000, .most_growths = 0};
    const auto batch = ran(PatchContact<Real>(executor(), model, options), scenes);
    for (std::size_t i = 0; i < scenes.size(); ++i, ++scenes_in_all) {
      const fem::ContactSolution found = batch.solution(i),
                                 expected = fem::PatchSolver(model, options).solve(scenes[i]);
      solved += found.steps.back().converged;
      not_alike += !solved_alike(found, expected);
      EXPECT_LE(difference(found, expected), tolerance) << describe(scenes[i]) << ", scene " << i;
    }
  }
  EXPECT_GE(solved, 0.8 * static_cast<double>(scenes_in_all));
  EXPECT_LE(not_alike, scenes_in_all / 20);
}

TEST(PatchContactSlow, LayersMatchTheTwin) {
  expect_layered_twin<double>({{0.2, 0.1, 0.45}, {1.294, 2, 0.3}, {0.006, 1, 0.45}}, 1e-4);
  expect_layered_twin<float>({{1.2, 0.2, 0.3}, {0.3, 1, 0.48}}, 1e-4);
}

TEST(PatchContactSlow, EveryShapeMatchesTheTwin) {
  const fem::LayerModel model = fem::layer_model(sensor_of(0.45));
  auto shapes = all_shapes();
  shapes.push_back(fem::Taylor{{2, 4, 5, 9, 20}, 6.0, 0.4, {1, 0.5, 2, 1, 0.25}});
  shapes.push_back(fem::Taylor{{}, 6.0, {}});
  shapes.push_back(fem::Profile{{-1, -0.2, 0.5, 1.5}, {0.05, 0, 0.001, 0.02}, 0.0, ""});  // presses beyond its ends
  shapes.push_back(fem::Cylinder{0.3});
  std::vector<fem::Scene> scenes;
  for (const auto& shape : shapes)
    for (const double position : {0.0, 3.3, -9.2})
      scenes.push_back({"", model.sensor, {shape, position}, 0.6, reversal()});
  const PatchContact<double> contact(executor(), model, {.accept = 2e-2, .most_growths = 0});  // as the twin
  const auto batch = ran(contact, scenes);
  const fem::PatchSolver twin(model, {.most_sweeps = 400, .most_growths = 0});
  for (std::size_t i = 0; i < scenes.size(); ++i)
    EXPECT_LE(difference(batch.solution(i), twin.solve(scenes[i])), agree_fp64) << describe(scenes[i]);
}

// ---------------------------------------------------------------------------------------------------------------------
// Bits

template <class Real>
class PatchBits : public ::testing::Test {
 protected:
  const fem::LayerModel model_ = fem::layer_model(sensor_of(0.45));

  /// body(scenes) for the scenes of each kind.
  template <class Body>
  void each_kind(std::size_t count, const Body& body) const {
    for (const auto& scenes : by_kind(mixed_scenes(model_.sensor, count, 5))) body(scenes);
  }
  PatchContact<Real> on(Executor& executor) const { return {executor, model_, {.most_sweeps = 200}}; }
  /// `pthread` compiles programs of its own: every day those by depth alone.
  void expect_same_for_any_threads_and_chunks(bool by_depth_alone) const {
    each_kind(60, [&](const auto& scenes) {
      Executor one{Device(), {.threads = 1}};
      const Hashes expected = hashes(on(one), scenes);
      for (const char* device : {"basic", "pthread"})
        for (const std::size_t chunk : {1, 4096}) {
          if (device == std::string_view("pthread") && by_depth_alone && (scenes.empty() || by_force(scenes.front())))
            continue;
          Executor executor{Device(device), {.threads = 3}};
          EXPECT_EQ(hashes(on(executor), scenes, chunk), expected) << device << ", chunks of " << chunk;
        }
    });
  }
};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(PatchBits, Precisions);

template <class Real>
class PatchBitsNightly : public PatchBits<Real> {};
TYPED_TEST_SUITE(PatchBitsNightly, Precisions);

TYPED_TEST(PatchBitsNightly, AreTheSameAtEveryNumberOfLanes) {
  this->each_kind(67, [&](const auto& scenes) {  // more than one tile of 64 at one lane
    Hashes expected;
    for (const Device& device : devices_of_all_lanes()) {
      Executor executor{device, {.threads = 1}};
      const Hashes found = hashes(this->on(executor), scenes);
      if (expected.empty()) expected = found;
      for (std::size_t i = 0; i < scenes.size(); ++i)
        ASSERT_EQ(found[i], expected[i]) << device.info().lanes_fp32 << " lanes, " << describe(scenes[i]);
    }
  });
}

using PatchBitsFp32 = PatchBits<float>;
TEST_F(PatchBitsFp32, AreTheSameForAnyThreadsAndChunks) { expect_same_for_any_threads_and_chunks(true); }
TYPED_TEST(PatchBitsNightly, AreTheSameForAnyThreadsAndChunks) { this->expect_same_for_any_threads_and_chunks(false); }

TYPED_TEST(PatchBits, AreTheSameInAnyOrderAndBatch) {
  this->each_kind(50, [&](const auto& scenes) {
    const auto contact = this->on(executor());
    const Hashes expected = hashes(contact, scenes);
    std::vector<std::size_t> order(scenes.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937_64(1));
    std::vector<fem::Scene> permuted;
    permuted.reserve(order.size());
    for (const std::size_t i : order) permuted.push_back(scenes[i]);
    const Hashes found = hashes(contact, permuted);
    for (std::size_t k = 0; k < order.size(); ++k) ASSERT_EQ(found[k], expected[order[k]]) << describe(permuted[k]);
    for (std::size_t from = 0, size = 1; from + size <= scenes.size(); from += size, size += 3) {
      const Hashes part = hashes(contact, std::span(scenes).subspan(from, size));
      ASSERT_TRUE(std::equal(part.begin(), part.end(), expected.begin() + static_cast<std::ptrdiff_t>(from))) << size;
    }
  });
}

TYPED_TEST(PatchBits, AreTheSameWithoutForces) {
  this->each_kind(20, [&](const auto& scenes) {
    const auto contact = this->on(executor());
    const auto run = [&](bool forces) {
      typename PatchContact<TypeParam>::Scenes all(contact);
      for (const fem::Scene& scene : scenes) all.push_back(scene, fem::load_path(scene.load));
      auto batch = contact.prepare(std::move(all), forces);
      batch.fill_outputs(static_cast<TypeParam>(nan));
      batch.run();
      return batch;
    };
    const auto with = run(true), without = run(false);
    const typename PatchContact<TypeParam>::Batch::View expected(with), found(without);
    const std::size_t tactels = static_cast<std::size_t>(scenes.front().sensor.tactels);
    std::vector<TypeParam> a(2 * tactels), b(2 * tactels);
    for (std::size_t i = 0; i < scenes.size(); ++i)
      for (int k = 0; k < expected.path_steps(i); ++k) {
        for (int row = 0; row < LANE_RESULT_ROWS; ++row)
          ASSERT_EQ(found.answer(i).result(k, row), expected.answer(i).result(k, row)) << describe(scenes[i]);
        if (static_cast<int>(expected.answer(i).result(k, RESULT_STATUS)) == LANE_NOT_RUN) continue;
        expected.answer(i).tactels(k, std::span(a)), found.answer(i).tactels(k, std::span(b));
        ASSERT_EQ(a, b) << describe(scenes[i]);
      }
    EXPECT_THROW(without.solution(0), std::logic_error);
  });
}

/// Other scenes beside each: NaN and infinity in every input, hard contacts, long paths.
TYPED_TEST(PatchBits, AreTheSameBesideBrokenScenes) {
  this->each_kind(40, [&](const auto& scenes) {
    if (scenes.empty()) return;
    const auto contact = this->on(executor());
    const Hashes expected = hashes(contact, scenes);
    const bool friction = scenes.front().friction != 0;
    std::vector<fem::Scene> mixed;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      fem::Scene stranger = scenes[i];
      if (i % 5 == 0) stranger.sensor.young = i % 2 ? nan : infinity;
      if (i % 5 == 1) stranger.indenter.position = nan;
      if (i % 5 == 2) stranger.indenter.shape = fem::Profile{{-30, 0, 30}, {1, nan, 1}, 0.0, ""};
      if (i % 5 == 3 && friction) stranger.friction = nan;
      if (i % 5 == 4 && !stranger.load.angle) stranger.load.tangential.assign(12, 1e3);
      mixed.insert(mixed.end(), {stranger, scenes[i]});
    }
    auto batch = ran(contact, mixed);
    std::size_t invalid = 0;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      ASSERT_EQ(hash(batch.solution(2 * i + 1)), expected[i]) << describe(scenes[i]);
      invalid += batch.result(2 * i, 0, RESULT_STATUS) == double(LANE_INVALID);
      for (const fem::ContactStep& step : batch.solution(2 * i).steps)
        ASSERT_TRUE(!step.converged || (std::isfinite(step.P) && std::isfinite(step.Q) && step.sigma_y.allFinite()));
    }
    EXPECT_GE(invalid, 3 * scenes.size() / 5);
  });
}

// ---------------------------------------------------------------------------------------------------------------------
// Certificate and fallback

TEST(PatchContact, TooSmallPatchIsFlaggedAndGrows) {
  const fem::LayerModel model = fem::endless_layer(sensor_of(0.45));
  fem::Scene scene{"", model.sensor, {fem::Parabola{10}, 0.4}, 0.5, reversal()};
  const PatchContact<double> contact(executor(), model);
  const std::vector<PatchContact<double>::Given> given{PatchContactExtent{-0.9, 0.3}};
  auto batch = contact.prepare(std::span(&scene, 1), given);
  batch.run();
  EXPECT_EQ(batch.result(0, 1, RESULT_STATUS), double(LANE_UNSOLVED));
  EXPECT_GT(batch.result(0, 1, RESULT_PENETRATION), 0.02);
  EXPECT_EQ(batch.patch(0, PATCH_ORIGIN), -0.9);
  EXPECT_EQ(batch.patch(0, PATCH_OUT_RIGHT), 3);
  const PatchContact<double>::Batch::View view(batch);
  const auto grown = patch_certificate(view.answer(0), 12).larger;
  ASSERT_TRUE(grown);
  EXPECT_NEAR(grown->right, 0.3 + 3.5 * 0.1, 1e-12);
}

/// Bonded contact spreads beyond what the search without friction finds: patches grow, and answers are those of larger
/// ones.
TEST(PatchContact, GrownPatchesAreCertified) {
  const fem::LayerModel model = fem::layer_model(sensor_of(0.3));
  std::vector<fem::Scene> scenes = mixed_scenes(model.sensor, 150, 2);
  PatchContactReport report;
  const PatchContact<double> contact(executor(), model, {.accept = 2e-2});  // as the twin
  const auto solutions = solve_patch_contact(contact, scenes, {}, &report);
  EXPECT_GT(report.grown, 2u);
  EXPECT_LE(report.fell_back, scenes.size() / 20);
  EXPECT_LE(report.unsolved, scenes.size() / 30);
  const fem::PatchSolver twin(model, {.most_sweeps = 400});
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (!solutions[i].fell_back && solutions[i].steps.back().converged) {
      EXPECT_LE(difference(solutions[i], twin.solve(scenes[i])), agree_fp64) << describe(scenes[i]);
    }
}

TEST(PatchContact, FallsBackWhereSweepsWereCutShort) {
  const fem::LayerModel model = fem::endless_layer(sensor_of(0.45));
  std::vector<fem::Scene> scenes;
  for (const auto& shape : all_shapes()) scenes.push_back({"", model.sensor, {shape, 0.2}, 0.5, reversal()});
  PatchContactReport report;
  const PatchContact<float> contact(executor(), model, {.most_sweeps = 3});
  const auto solutions = solve_patch_contact(contact, scenes, {}, &report);
  EXPECT_GE(report.fell_back, scenes.size() / 2);
  EXPECT_EQ(report.unsolved, 0u);
  for (const auto& solution : solutions)
    for (const auto& step : solution.steps) EXPECT_TRUE(step.converged);
}

/// Angle control with little friction, which sweeps reach, and bonded contacts that lose elements in wide drags over
/// compressible rubber, where sweeps go round in circles and the exact solver answers.
TEST(PatchContact, LittleFrictionAndBondedCompressibleContactsAreSolved) {
  const fem::LayerModel model = fem::endless_layer(sensor_of(0.0));
  std::vector<fem::Scene> angles, bonded;
  for (const auto& shape : all_shapes())
    for (const double mu : {0.01, 0.03, 0.08}) {
      fem::Scene scene{"", model.sensor, {shape, 0.2}, mu, {}};
      scene.load.indentation.clear();
      scene.load.normal_force = {0.1};
      scene.load.angle = std::atan(0.7 * mu) * 180 / std::numbers::pi;
      scene.load.indentation_steps = 3;
      angles.push_back(scene);
      scene.load = reversal();
      scene.friction = infinity;
      for (double& x : scene.load.tangential) x *= 100 * mu;
      bonded.push_back(scene);
    }
  PatchContactReport report;
  solve_patch_contact(PatchContact<float>(executor(), model), angles, {}, &report);
  EXPECT_LE(report.fell_back, 1u);  // the others by sweeps alone
  EXPECT_EQ(report.unsolved, 0u);
  solve_patch_contact(PatchContact<float>(executor(), model), bonded, {}, &report);
  EXPECT_EQ(report.unsolved, 0u);
}

TEST(PatchContact, ManySensorsInOneCall) {
  std::vector<fem::Scene> scenes;
  for (const double poisson : {0.3, 0.45})
    for (const auto& shape : all_shapes()) scenes.push_back({"", sensor_of(poisson), {shape, 0.0}, 0.5, reversal()});
  std::shuffle(scenes.begin(), scenes.end(), std::mt19937_64(3));
  const ContactStream stream(executor(), model_of(usual_patch()));
  const auto together = stream.solve(scenes);
  for (std::size_t i = 0; i < scenes.size(); i += 7)
    EXPECT_EQ(hash(together[i]), hash(stream.solve(std::span(&scenes[i], 1))[0]));
}

TEST(PatchContact, NumberOfElementsWithoutProgramIsRefused) {
  EXPECT_THROW(PatchContact<float>(executor(), fem::endless_layer(fem::Sensor{}), {.elements = 10}), ValueError);
}

// ---------------------------------------------------------------------------------------------------------------------
// Laws

/// A launcher for scenes of this sensor, an endless layer, that sweeps to `tolerance`.
PatchContact<double> endless(const fem::Sensor& sensor, double tolerance = 1e-12) {
  return {executor(), fem::endless_layer(sensor), {.tolerance = tolerance, .accept = 2e-2}};
}

fem::ContactSolution solved(const PatchContact<double>& contact, const fem::Scene& scene) {
  return ran(contact, std::span(&scene, 1)).solution(0);
}

/// The layer's base bears what presses and drags on its surface, all of it within some thicknesses: the sensor is long.
TEST(PatchContact, BaseStressBalancesTheForces) {
  fem::Sensor sensor = sensor_of(0.45);
  sensor.length = 60;
  sensor.tactels = 1201;
  const auto contact = endless(sensor, 1e-3);
  for (const auto& shape : all_shapes()) {
    if (std::holds_alternative<fem::Flat>(shape) && !std::get<fem::Flat>(shape).half_width) continue;  // to the ends
    const fem::ContactSolution solution = solved(contact, {"", sensor, {shape, 0.3}, 0.6, reversal()});
    const double dx = solution.tactel_x[1] - solution.tactel_x[0];
    for (const fem::ContactStep& step : solution.steps) {
      // The table is linear between rows h / 30 apart; the rest is less.
      EXPECT_NEAR(step.sigma_y.sum() * dx, -step.P, 1e-3 * step.P) << fem::shape_name(shape);
      EXPECT_NEAR(step.tau_xy.sum() * dx, step.Q, 1e-3 * step.P) << fem::shape_name(shape);
    }
  }
}

/// Mirrored in x, P stays, Q and tau change their sign; tactels count from the other end.
TEST(PatchContact, MirrorImageOfASceneHasTheMirroredAnswer) {
  const auto contact = endless(sensor_of(0.45));
  for (const auto& shape : all_shapes()) {
    fem::Scene scene{"", sensor_of(0.45), {shape, 1.7}, 0.5, reversal()}, mirrored = scene;
    mirrored.indenter.position = -1.7;
    for (double& x : mirrored.load.tangential) x = -x;
    const auto one = solved(contact, scene), other = solved(contact, mirrored);
    for (std::size_t k = 0; k < one.steps.size(); ++k) {
      const fem::ContactStep &a = one.steps[k], &b = other.steps[k];
      ASSERT_TRUE(a.converged && b.converged) << fem::shape_name(shape);
      EXPECT_NEAR(a.P, b.P, 1e-9 * a.P) << fem::shape_name(shape);
      EXPECT_NEAR(a.Q, -b.Q, 1e-9 * a.P) << fem::shape_name(shape);
      EXPECT_LE((a.tau_xy + b.tau_xy.reverse()).cwiseAbs().maxCoeff(), 1e-9 * a.P) << fem::shape_name(shape);
    }
  }
}

/// Forces go with E, and with the size of the whole scene; S with neither.
TEST(PatchContact, ScalesWithStiffnessAndSize) {
  fem::Scene scene{"", sensor_of(0.45), {fem::Wedge{150}, 0.7}, 0.5, reversal()}, stiff = scene, large = scene;
  stiff.sensor.young = 7 * scene.sensor.young;
  constexpr double size = 3.7;
  large.sensor.length *= size;
  large.sensor.thickness *= size;
  large.indenter.position *= size;
  for (double& d : large.load.indentation) d *= size;
  for (double& x : large.load.tangential) x *= size;
  const auto contact = endless(scene.sensor);
  const auto one = solved(contact, scene), seven = solved(contact, stiff), sized = solved(endless(large.sensor), large);
  for (std::size_t k = 0; k < one.steps.size(); ++k) {
    EXPECT_NEAR(seven.steps[k].P, 7 * one.steps[k].P, 1e-12 * seven.steps[k].P);
    EXPECT_NEAR(seven.steps[k].Q, 7 * one.steps[k].Q, 1e-12 * seven.steps[k].P);
    EXPECT_NEAR(sized.steps[k].P, size * one.steps[k].P, 1e-9 * sized.steps[k].P);
    EXPECT_NEAR(sized.steps[k].Q, size * one.steps[k].Q, 1e-9 * sized.steps[k].P);
    EXPECT_NEAR(*sized.steps[k].slip_index, *one.steps[k].slip_index, 1e-9);
    EXPECT_LE((sized.steps[k].sigma_y - one.steps[k].sigma_y).cwiseAbs().maxCoeff(), 1e-9 * one.steps[k].P);
  }
}

/// A parabola on a layer much thicker than the contact is wide: Hertz's peak pressure (P E* / (pi R))^(1/2), K. L.
/// Johnson, Contact Mechanics (1985), section 4.2(c).
TEST(PatchContact, ThickLayerHasTheContactOfHertz) {
  fem::Sensor sensor = sensor_of(0.45);
  sensor.thickness = 600;
  sensor.length = 4000;
  fem::Scene scene{"", sensor, {fem::Parabola{10}, 0}, 0.0, {}};
  scene.load.indentation = {0.3};
  for (const int elements : {12, 24}) {
    const PatchContact<double> contact(executor(), fem::endless_layer(sensor), {.elements = elements});
    auto batch = ran(contact, std::span(&scene, 1));
    const fem::ContactStep step = batch.solution(0).steps.back();
    const double stiffness = sensor.young / (1 - 0.45 * 0.45);
    const double peak = std::sqrt(step.P * stiffness / (std::numbers::pi * 10));
    EXPECT_NEAR(step.normal_force.maxCoeff() / batch.patch(0, PATCH_ELEMENT), peak, 0.01 * peak) << elements;
  }
}

/// Forces that a scene gives are met to the tolerance; the angle is theirs.
TEST(PatchContact, GivenForcesAreMet) {
  const fem::LayerModel model = fem::endless_layer(sensor_of(0.45));
  const auto scenes = random_force_scenes(model.sensor, 100, 8);
  const auto solutions = solve_patch_contact(PatchContact<float>(executor(), model), scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::ContactStep& last = solutions[i].steps.back();
    if (!last.converged) continue;
    const double P = scenes[i].load.normal_force.back();
    EXPECT_NEAR(last.P, P, 1.1e-3 * P) << describe(scenes[i]);
    const double ratio = scenes[i].load.angle ? std::tan(*scenes[i].load.angle * std::numbers::pi / 180) : 0;
    if (scenes[i].load.angle) {
      EXPECT_NEAR(last.Q, P * ratio, 2.5e-3 * P) << describe(scenes[i]);
    }
  }
}

TEST(PatchContact, GoesOnUntilTheContactSlides) {
  fem::Scene scene{"", sensor_of(0.45), {fem::Parabola{10}, 0.0}, 0.4, {}};
  scene.load.tangential_step = 0.05;
  const auto solution = solved(endless(scene.sensor, 1e-3), scene);
  EXPECT_TRUE(solution.sliding);
  EXPECT_LT(solution.steps.size(), 30u);
  EXPECT_NEAR(*solution.steps.back().slip_index, 1.0, 1e-12);
  EXPECT_LT(*solution.steps[solution.steps.size() - 2].slip_index, 1.0);
}

/// Without friction only depth counts: drags leave every bit as it was.
TEST(PatchContact, FrictionlessDragsChangeNothing) {
  const fem::LayerModel model = fem::endless_layer(sensor_of(0.45));
  std::vector<fem::Scene> scenes;
  for (const auto& shape : all_shapes()) scenes.push_back({"", model.sensor, {shape, 0.3}, 0.0, reversal()});
  const auto batch = ran(PatchContact<float>(executor(), model), scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::ContactSolution solution = batch.solution(i);
    for (std::size_t k = 2; k < solution.steps.size(); ++k) {
      EXPECT_TRUE(solution.steps[k].converged);
      EXPECT_EQ(solution.steps[k].P, solution.steps[1].P);
      EXPECT_EQ(solution.steps[k].Q, 0);
      EXPECT_EQ(solution.steps[k].iterations, 0);
      EXPECT_FALSE(solution.steps[k].slip_index);
    }
  }
}

/// Lifted off the surface, nothing bears force.
TEST(PatchContact, LiftedIndenterBearsNothing) {
  fem::Scene scene{"", sensor_of(0.45), {fem::Flat{3.0}, 0.0}, 0.4, {}};
  scene.load.indentation = {0.2, 0.0};
  const auto solution = solved(endless(scene.sensor, 1e-3), scene);
  ASSERT_EQ(solution.steps.size(), 2u);
  EXPECT_GT(solution.steps[0].P, 0);
  EXPECT_EQ(solution.steps[1].P, 0);
  EXPECT_EQ(solution.steps[1].sigma_y.cwiseAbs().maxCoeff(), 0);
}

}  // namespace tactel::host::patch_contact_test
