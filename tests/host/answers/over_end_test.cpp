// SPDX-License-Identifier: Apache-2.0

// Contacts over the end of the rubber, where the surface ends in a corner, at nu = 0: truth from meshes graded towards
// the end, 222, 338 and 524 columns, of an independent program (tests/fem/independent_block.py's product of lines).
#include <gtest/gtest.h>

#include <cmath>

#include "host/answers/line_error.h"
#include "host/answers/solve.h"
#include "host/contact/lines/contact_fallback.h"
#include "host/contact/lines/patch_contact.h"

namespace tactel::host::over_end_test {

fem::Scene over_end(fem::Shape shape, double position, double friction) {
  return {
      .sensor =
          {.length = 11.014, .thickness = 0.939, .young = 0.7991, .poisson = 0, .tactels = 33, .tactel_span = 9.913},
      .indenter = {std::move(shape), position},
      .friction = friction,
      .model = fem::SurfaceModel::patch};
}

/// A scene, and S of one of its steps: three meshes agree within 0.001.
struct OverEnd {
  const char* name;
  fem::Scene scene;
  std::size_t step;
  double S;
};

OverEnd profile() {
  const fem::Profile shape{.x = {-1.399, -1.115, -0.8047, -0.6947, -0.6331, -0.1774, 0.64, 1.1674},
                           .y = {0.03052, 0.01064, 0, 0.00522, 0.00952, 0.05283, 0.1649, 0.26697}};
  OverEnd of{"Profile", over_end(shape, -4.64825, 0.47998), 12, 0.795};
  of.scene.load.indentation = {0.046434};
  of.scene.load.tangential = {0.001791, 0.004732, 0.006233, 0.004023, -0.001319, -0.000434,
                              0.003941, 0.008006, 0.01138,  0.012821, 0.01686,   0.01329};
  return of;
}

OverEnd rounded_flat() {
  OverEnd of{"RoundedFlat", over_end(fem::RoundedFlat{0.384264, 7.50989}, -5.323359, 0.911085), 4, 0.905};
  of.scene.load.indentation = {};
  of.scene.load.normal_force = {0.0049167, 0.007375, 0.0049167};
  of.scene.load.tangential = {0.006618, 0.014815, 0.027024, 0.036342, 0.043888};
  return of;
}

SolveOutcome solved(const OverEnd& of, const SolveOptions& options) {
  SolveOutcome outcome = solve(of.scene, options);
  EXPECT_TRUE(every_step_converged(outcome.solution));
  return outcome;
}

class OverTheEnd : public testing::TestWithParam<OverEnd (*)()> {};

/// 0.002 of the 0.005 is what 120 nodes leave, and 0.001 the truth's own.
TEST_P(OverTheEnd, TheReferenceResolvesTheCorner) {
  const OverEnd of = GetParam()();
  EXPECT_NEAR(*solved(of, {.rung = "reference"}).solution.steps[of.step].slip_index, of.S, 0.005);
}

TEST_P(OverTheEnd, TheSaidErrorCoversTheMadeOne) {
  const OverEnd of = GetParam()();
  for (const char* rung : {"", "patch-8", "patch-12", "patch-16", "patch-24", "paper", "mesh-81"}) {
    const SolveOutcome outcome = solved(of, {.rung = rung});
    const auto said = mesh_error(outcome);
    ASSERT_TRUE(said) << rung;
    const std::size_t step = asked_steps(outcome.scene.load, outcome.solution.steps.size()).at(of.step);
    EXPECT_GE(said->expected.S, std::abs(*outcome.solution.steps[step].slip_index - of.S)) << rung;
  }
}

/// Patches that are not exact have the unresolved corner in common: their differences do not show it.
TEST_P(OverTheEnd, ThePlannerTakesAnExactRung) {
  const OverEnd of = GetParam()();
  const SolveOutcome outcome = solved(of, {.accuracy = 0.02});
  EXPECT_TRUE(outcome.rung.exact) << outcome.rung.name;
  EXPECT_LE(std::abs(*outcome.solution.steps[of.step].slip_index - of.S), outcome.plan->estimate);
}

const auto name_of = [](const auto& info) { return info.param().name; };
INSTANTIATE_TEST_SUITE_P(Of, OverTheEnd, testing::Values(profile), name_of);
INSTANTIATE_TEST_SUITE_P(Nightly, OverTheEnd, testing::Values(rounded_flat), name_of);

}  // namespace tactel::host::over_end_test
