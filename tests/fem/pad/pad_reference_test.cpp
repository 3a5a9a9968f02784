// SPDX-License-Identifier: Apache-2.0

// The reference of pads: its own error, and the solver judged by it.
#include "fem/pad/pad_reference.h"

#include <gtest/gtest.h>

#include "fem/pad/pad_mix.h"

namespace tactel::fem::pad_reference_test {

const PadOptions coarse{.cells = 24,
                        .tolerance = 1e-4,
                        .pressing_increments = 4,
                        .drag_increments = 1,
                        .limit_increments = 3,
                        .ladder = false};

TEST(PadReference, StatesItsOwnError) {
  PadSensor sensor;
  const PadLayer layer(sensor.poisson);
  PadOptions fine = coarse;
  fine.cells = 40;
  PadMix mix(11, &sensor);
  for (int k = 0; k < 3; ++k) {
    const PadScene scene = mix();
    const PadReferenceSolution answer = PadReference(layer, coarse).solve(scene);
    const auto off = pad_difference(answer.solution, PadReference(layer, fine).solve(scene).solution);
    // An estimate, not a bound: the number of cells that touch jumps by steps.
    EXPECT_LE(off.S, 3 * answer.error.S + 1e-3) << k;
    EXPECT_LE(off.P, 3 * answer.error.P + 1e-3) << k;
    EXPECT_LE(off.sigma, 3 * answer.error.sigma + 2e-3) << k;
    EXPECT_LE(off.tau, 3 * answer.error.tau + 2e-3) << k;
    EXPECT_LE(answer.error.S, 0.01) << k;
  }
}

TEST(PadReference, JudgesTheSolver) {
  PadSensor sensor;
  const PadLayer layer(sensor.poisson);
  PadMix mix(12, &sensor);
  for (int k = 0; k < 9; ++k) {
    const PadScene scene = mix();
    const auto off = pad_difference(PadSolver(layer).solve(scene), PadReference(layer, coarse).solve(scene).solution);
    EXPECT_LE(off.S, 0.04) << k;  // 0.02 of 12 cells, and as much of this judge
    EXPECT_LE(off.P, 0.03) << k;
  }
}

}  // namespace tactel::fem::pad_reference_test
