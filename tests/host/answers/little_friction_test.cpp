// SPDX-License-Identifier: Apache-2.0

// Lines with little friction in fp32, beside fp64: what sweeps leave is small beside mu P.
#include <gtest/gtest.h>

#include "host/answers/solve.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::little_friction_test {

class LittleFriction : public testing::TestWithParam<double> {};

/// A tolerance of 1e-3 at mu = 0.01 leaves 0.0084 of S; with less friction it left 0.018 (mu 0.003) and 0.11 (0.001).
TEST_P(LittleFriction, IsAsRightInFp32AsAHundredth) {
  const double mu = GetParam();
  fem::Scene scene;
  scene.model = fem::SurfaceModel::patch;
  scene.indenter.shape = fem::Parabola{10};
  scene.friction = mu;
  scene.load.indentation = {0.15};
  for (const double x : {0.05, 0.1, 0.2, 0.3, 0.15, -0.1}) scene.load.tangential.push_back(mu * x);
  for (const char* rung : {"patch-12", "mesh-81"}) {
    const auto single = solve(scene, {.rung = rung, .precision = "fp32"}).solution;
    const auto exact = solve(scene, {.rung = rung, .precision = "fp64"}).solution;
    ASSERT_EQ(single.steps.size(), exact.steps.size());
    for (std::size_t k = 0; k < exact.steps.size(); ++k) {
      EXPECT_TRUE(single.steps[k].converged) << rung;
      EXPECT_NEAR(*single.steps[k].slip_index, *exact.steps[k].slip_index, 0.01) << rung << " step " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Mu, LittleFriction, testing::Values(1e-3, 3e-3, 9e-3));

}  // namespace tactel::host::little_friction_test
