// SPDX-License-Identifier: Apache-2.0

// The batched contact kernel against the full-mesh reference, against its Eigen twin, and against laws that neither
// knows.
#include "host/contact/lines/gap_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "fem/gap/gap_reference.h"
#include "fem/gap/gap_sweep.h"
#include "fem/numbers/value_error.h"
#include "host/contact/lines/solve_on_rung.h"
#include "kernels/shared/contact_layout.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/device/test_device.h"

namespace gap_sweep_test {

using namespace tactel;
using fem::base_force_difference;
using host::executor;
using tactel::tests::all_shapes;
using tactel::tests::paper_mesh;
using tactel::tests::random_scenes;
using tactel::tests::reversal;

const std::vector<double> all_nu{0, 0.3, 0.45, 0.49, 0.4999}, all_mu{0, 0.2, 0.5, 1, 5};

std::string describe(const fem::Scene& s) {
  return std::string(fem::shape_name(s.indenter.shape)) + " at " + std::to_string(s.indenter.position) + ", nu " +
         std::to_string(s.sensor.poisson) + ", mu " + std::to_string(s.friction);
}

/// Agreement that is asked of fp64 and fp32, over the largest base force: fp64 sweeps to a last change of 1e-11, and
/// slow lanes (contraction 0.99 a sweep) leave some 100 times that; fp32 stores C to 6e-8 with condition up to 511, and
/// stops at 1e-5.
constexpr double agree_fp64 = 1e-8, agree_fp32 = 1e-3;

void expect_reference(const std::vector<fem::Scene>& scenes) {
  const auto fp64 = host::solve_on_meshes(executor(), scenes, host::Precision::fp64);
  const auto fp32 = host::solve_on_meshes(executor(), scenes, host::Precision::fp32);
  fem::GapReference reference(scenes.front().sensor);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const auto truth = reference.solve(scenes[i]);
    EXPECT_LE(base_force_difference(fp64[i], truth), agree_fp64) << describe(scenes[i]);
    EXPECT_LE(base_force_difference(fp32[i], truth), agree_fp32) << describe(scenes[i]);
    for (std::size_t k = 0; k < truth.steps.size(); ++k) {
      EXPECT_TRUE(truth.steps[k].converged && fp64[i].steps[k].converged && fp32[i].steps[k].converged)
          << describe(scenes[i]) << ", step " << k;
      EXPECT_EQ(fp64[i].steps[k].slip_index.has_value(), truth.steps[k].slip_index.has_value());
    }
  }
}

class EveryShape : public ::testing::TestWithParam<double> {};

TEST_P(EveryShape, MeshBMatchesReferenceForEveryFriction) {
  std::vector<fem::Scene> scenes;
  for (double mu : all_mu)
    for (const auto& shape : all_shapes()) {
      fem::Scene scene{"", paper_mesh('B'), {shape, 0.0}, mu, reversal()};
      scene.sensor.poisson = GetParam();
      scenes.push_back(scene);
    }
  expect_reference(scenes);
}

/// On mesh A the reference takes about a second a scene: each shape meets each nu once, with friction going round.
class EveryShapeOnMeshA : public EveryShape {};
TEST_P(EveryShapeOnMeshA, MatchesReference) {
  std::vector<fem::Scene> scenes;
  const std::size_t row = std::find(all_nu.begin(), all_nu.end(), GetParam()) - all_nu.begin();
  const auto shapes = all_shapes();
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    fem::Scene scene{"", paper_mesh('A'), {shapes[k], 0.0}, all_mu[(k + row) % all_mu.size()], reversal()};
    scene.sensor.poisson = GetParam();
    scenes.push_back(scene);
  }
  expect_reference(scenes);
}

INSTANTIATE_TEST_SUITE_P(Poisson, EveryShape, ::testing::ValuesIn(all_nu));
INSTANTIATE_TEST_SUITE_P(Poisson, EveryShapeOnMeshA, ::testing::Values(0.4999));
INSTANTIATE_TEST_SUITE_P(Nightly, EveryShapeOnMeshA, ::testing::Values(0, 0.3, 0.45, 0.49));

TEST(GapSweep, EveryElementMatchesReference) {
  for (auto element : {fem::Element::q4, fem::Element::q4i, fem::Element::q8})
    for (auto stress : {fem::StressRecovery::reaction, fem::StressRecovery::element}) {
      fem::Scene scene{"", paper_mesh('B'), {fem::Parabola{10}, 1.3}, 0.6, reversal()};
      scene.sensor.element = element;
      scene.sensor.stress = stress;
      const auto batched = host::solve_on_meshes(executor(), std::vector{scene}, host::Precision::fp64)[0];
      const auto truth = fem::solve_gap_reference(scene);
      EXPECT_LE(base_force_difference(batched, truth), agree_fp64) << fem::name(element);
      for (std::size_t k = 0; k < truth.steps.size(); ++k) {
        const double scale = truth.steps[k].sigma_y.cwiseAbs().maxCoeff();
        EXPECT_LE((batched.steps[k].sigma_y - truth.steps[k].sigma_y).cwiseAbs().maxCoeff(), agree_fp64 * scale)
            << fem::name(element);
        EXPECT_LE((batched.steps[k].tau_xy - truth.steps[k].tau_xy).cwiseAbs().maxCoeff(), agree_fp64 * scale)
            << fem::name(element);
      }
    }
}

/// Normal force, normal force with drag, and both forces by an angle. The search stops at 10 times the sweeps'
/// tolerance in force.
TEST(GapSweep, ForceControlMatchesReference) {
  for (char mesh : {'B', 'A'})
    for (int kind = 0; kind < 3; ++kind) {
      fem::Scene scene{"", paper_mesh(mesh), {fem::Cylinder{20}, 0.7}, 0.5, {}};
      scene.load.indentation.clear();
      scene.load.normal_force = {0.3};
      scene.load.indentation_steps = 3;
      if (kind == 1) scene.load.tangential = {0.05, 0.1, -0.05};
      if (kind == 2) scene.load.angle = 20.0;
      const auto fp64 = host::solve_on_meshes(executor(), std::vector{scene}, host::Precision::fp64)[0];
      const auto fp32 = host::solve_on_meshes(executor(), std::vector{scene}, host::Precision::fp32)[0];
      const auto truth = fem::solve_gap_reference(scene);
      EXPECT_LE(base_force_difference(fp64, truth), agree_fp64) << "kind " << kind;
      EXPECT_LE(base_force_difference(fp32, truth), agree_fp32) << "kind " << kind;
      for (std::size_t k = 0; k < truth.steps.size(); ++k) {
        EXPECT_TRUE(fp64.steps[k].converged) << "kind " << kind << ", step " << k;
        EXPECT_NEAR(fp64.steps[k].indentation, truth.steps[k].indentation, 1e-8) << "kind " << kind;
        EXPECT_NEAR(fp64.steps[k].tangential, truth.steps[k].tangential, 1e-8) << "kind " << kind;
      }
    }
}

TEST(GapSweep, GoesOnUntilTheContactSlides) {
  fem::Scene scene{"", paper_mesh('B'), {fem::Parabola{10}, 0.0}, 0.4, {}};
  scene.load.tangential_step = 0.05;
  const auto batched = host::solve_on_meshes(executor(), std::vector{scene}, host::Precision::fp64)[0];
  const auto truth = fem::solve_gap_reference(scene);
  ASSERT_EQ(batched.steps.size(), truth.steps.size());
  EXPECT_TRUE(batched.sliding);
  EXPECT_NEAR(*batched.steps.back().slip_index, 1.0, 1e-12);
  EXPECT_LT(*batched.steps[batched.steps.size() - 2].slip_index, 1.0);
}

/// Ragged sizes around a group; outputs hold NaN before the run.
class Ragged : public ::testing::TestWithParam<int> {};

template <class Real>
void expect_twin(int count, double tolerance, bool friction = true) {
  auto scenes = random_scenes(paper_mesh('B'), count, 20 + count);
  for (fem::Scene& scene : scenes)
    if (!friction) scene.friction = 0;
  host::GapSweep<Real> sweep(executor(), scenes.front().sensor);
  auto batch = sweep.prepare(scenes);
  batch.fill_outputs(std::numeric_limits<Real>::quiet_NaN());
  batch.run();
  const fem::GapSweep<double> twin(sweep.condensation());
  for (int i = 0; i < count; ++i)
    ASSERT_LE(base_force_difference(batch.solution(i), twin.solve(scenes[i])), tolerance)
        << "lane " << i << ": " << describe(scenes[i]);
}

TEST_P(Ragged, Fp64MatchesTwin) { expect_twin<double>(GetParam(), agree_fp64); }
TEST_P(Ragged, Fp32MatchesTwin) { expect_twin<float>(GetParam(), agree_fp32); }
TEST_P(Ragged, FrictionlessFp64MatchesTwin) { expect_twin<double>(GetParam(), agree_fp64, false); }
TEST_P(Ragged, FrictionlessFp32MatchesTwin) { expect_twin<float>(GetParam(), agree_fp32, false); }
INSTANTIATE_TEST_SUITE_P(AroundGroup, Ragged, ::testing::Values(1, 15, 16, 17, 23, 24, 25, 47, 48, 49, 500));

/// Pressed only. mu = 1e-30 takes the program with tangential unknowns, where tractions of 1e-30 of the pressure are
/// lost in rounding and leave P as it is without them, bit for bit; also where both kinds come in one call.
TEST(GapSweep, FrictionlessIsTheLimitOfLittleFriction) {
  auto scenes = random_scenes(paper_mesh('B'), 60, 5);
  const std::size_t count = scenes.size();
  for (std::size_t i = 0; i < count; ++i) {
    scenes[i].load.tangential.clear();
    scenes[i].friction = 0;
    scenes.push_back(scenes[i]);
    scenes.back().friction = 1e-30;
  }
  for (auto precision : {host::Precision::fp32, host::Precision::fp64}) {
    const auto solutions = host::solve_on_meshes(executor(), scenes, precision);
    std::size_t touching = 0;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < solutions[i].steps.size(); ++k) {
        const fem::ContactStep &none = solutions[i].steps[k], &little = solutions[count + i].steps[k];
        touching += none.P > 0;
        ASSERT_EQ(none.P, little.P) << describe(scenes[i]) << ", step " << k;
        ASSERT_EQ(none.iterations, little.iterations) << describe(scenes[i]) << ", step " << k;
        ASSERT_FALSE(none.slip_index);
      }
    EXPECT_GT(touching, count);  // steps; sharp indenters between two nodes touch none
  }
}

/// Without friction only depth counts: drags leave every bit as it was, and cost no sweep.
TEST(GapSweep, FrictionlessDragsChangeNothing) {
  std::vector<fem::Scene> scenes;
  for (const auto& shape : all_shapes()) scenes.push_back({"", paper_mesh('B'), {shape, 0.3}, 0.0, reversal()});
  for (const auto& solution : host::solve_on_meshes(executor(), scenes, host::Precision::fp32)) {
    const fem::ContactStep& pressed = solution.steps[1];
    for (std::size_t k = 2; k < solution.steps.size(); ++k) {
      const fem::ContactStep& step = solution.steps[k];
      EXPECT_TRUE(step.converged);
      EXPECT_EQ(step.P, pressed.P);
      EXPECT_EQ(step.Q, 0);
      EXPECT_EQ(step.sigma_y, pressed.sigma_y);
      EXPECT_EQ(step.iterations, 0);
      EXPECT_EQ(step.tangential, static_cast<float>(reversal().tangential[k - 2]));
    }
  }
}

TEST(GapSweep, RefusesABatchOfDifferentKinds) {
  auto scenes = random_scenes(paper_mesh('B'), 2, 11);
  const host::GapSweep<float> sweep(executor(), scenes.front().sensor);
  EXPECT_NO_THROW(sweep.prepare(scenes));
  scenes[1].friction = 0;
  EXPECT_THROW(sweep.prepare(scenes), std::invalid_argument);
}

/// Gap elements at every node from the start, or only where the indenter comes near: the same contact.
TEST(GapSweep, WindowCostsNoAccuracy) {
  const auto scenes = random_scenes(paper_mesh('B'), 100, 12);
  const auto windows = host::solve_on_meshes(executor(), scenes, host::Precision::fp64);
  const auto all = host::solve_on_meshes(executor(), scenes, host::Precision::fp64, {.reach = 1e6});
  for (std::size_t i = 0; i < scenes.size(); ++i)
    ASSERT_LE(base_force_difference(windows[i], all[i]), agree_fp64) << describe(scenes[i]);
}

TEST(GapSweep, UnreachableToleranceIsSaidNotHidden) {
  std::vector scenes(5, fem::Scene{"", paper_mesh('B'), {fem::Parabola{10}, 0.0}, 0.5, reversal()});
  for (const auto& solution :
       host::solve_on_meshes(executor(), scenes, host::Precision::fp64, {.most_sweeps = 2, .fallback = false}))
    EXPECT_FALSE(solution.steps.front().converged);
  // Less than rounding: the fallback cannot, either.
  for (const auto& solution : host::solve_on_meshes(executor(), scenes, host::Precision::fp64, {.accept = 1e-30})) {
    EXPECT_TRUE(solution.fell_back);
    EXPECT_FALSE(solution.steps.back().converged);
  }
}

TEST(GapSweep, RefusesAnInvalidScene) {
  auto scenes = random_scenes(paper_mesh('B'), 2, 11);
  scenes[1].sensor.poisson = 0.5;
  EXPECT_THROW(host::solve_on_meshes(executor(), scenes, host::Precision::fp64), ValueError);
}

}  // namespace gap_sweep_test
