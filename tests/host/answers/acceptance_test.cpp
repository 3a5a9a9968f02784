// SPDX-License-Identifier: Apache-2.0

// What a rung accepts: 0.02 in fp32 and 1e-6 in fp64 at most, whatever its model.
#include <gtest/gtest.h>

#include <cmath>

#include "fem/gap/contact_laws.h"
#include "host/answers/solve.h"
#include "host/contact/contact_model.h"
#include "host/contact/lines/solve_on_rung.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::acceptance_test {

constexpr double bound(Precision precision) { return precision == Precision::fp32 ? 0.02 : 1e-6; }

/// A round bar pressed into nearly incompressible rubber: sweeps to 1e-2 leave a residual of 0.048 on 41 columns.
fem::Scene bar() {
  return {.sensor = {.poisson = 0.499},
          .indenter = {.shape = fem::Cylinder{30}},
          .friction = 1,
          .load = {.indentation = {0.2}}};
}

void expect_accepted(const fem::ContactSolution& solution, double most) {
  for (const fem::ContactStep& step : solution.steps) {
    EXPECT_TRUE(step.converged);
    EXPECT_LE(fem::largest(step.residual), most);
  }
}

class Acceptance : public testing::TestWithParam<std::string> {};

TEST_P(Acceptance, OfARungHoldsTheBound) {
  Executor executor(device());
  const Rung& named = rung_named(GetParam());
  const fem::Scene scene = bar();
  expect_accepted(solve_on_rung(executor, std::span(&scene, 1), named).front(), bound(named.precision));
  if (named.exact) return;
  for (const Precision precision : {Precision::fp32, Precision::fp64}) {
    Rung rung = named;
    rung.precision = precision;
    const ContactModel model = model_of(rung);
    const auto* on_patch = std::get_if<PatchModel>(&model.surface);
    const GapSweepOptions mesh = on_patch ? on_patch->mesh : std::get<MeshModel>(model.surface).options;
    const fem::Sensor small{.columns = 5, .rows = 3};
    const auto accepted = [&](const auto& launcher) { return launcher.options().accept; };
    const auto sensor = fem::endless_layer(scene.sensor);
    const bool fp32 = precision == Precision::fp32;
    EXPECT_LE(
        fp32 ? accepted(GapSweep<float>(executor, small, mesh)) : accepted(GapSweep<double>(executor, small, mesh)),
        bound(precision));
    if (!on_patch) continue;
    const fem::PatchOptions& patch = on_patch->options;
    EXPECT_LE(fp32 ? accepted(PatchContact<float>(executor, sensor, patch))
                   : accepted(PatchContact<double>(executor, sensor, patch)),
              bound(precision));
  }
}
INSTANTIATE_TEST_SUITE_P(EveryRung, Acceptance,
                         testing::Values("patch-8", "patch-12", "patch-16", "patch-24", "paper", "mesh-41", "mesh-81",
                                         "mesh-161", "reference"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::erase(name, '-');
                           return name;
                         });

/// Pressed straight down, a symmetric contact has Q = 0. The exact fallback leaves what rounding does.
TEST(Acceptance, ASymmetricPressHasNoTangentialForce) {
  const fem::ContactStep step = solve(bar(), {.rung = "mesh-41"}).solution.steps.back();
  EXPECT_TRUE(step.converged);
  EXPECT_LE(std::abs(step.Q), 1e-6 * step.P);
}

}  // namespace tactel::host::acceptance_test
