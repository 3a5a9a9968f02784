// SPDX-License-Identifier: Apache-2.0

// Written by `build/bench/tactel_ladder_study 640 500 FILE`; do not edit.
// 640 contacts drawn with seed 500: 8 shapes in turn, -4 to 4 mm off centre, nu 0.3, 0.45, 0.49 or 0.499, mu 0.1
// to 1.5, 0.05 to 0.3 mm deep, eight drags, reversed in one scene of four. Device: basic-skylake-avx512-Intel(R)
// Xeon(R) Processor
#include "host/answers/planner.h"

namespace tactel::host {

std::span<const MeasuredRung> measured_ladder() {
  static constexpr MeasuredRung rungs[] = {
      {"patch-8", {0.00826, 1.55}, {0.0099, 0.65}, 0.0321},  {"patch-12", {0.00354, 2.1}, {0.00405, 1.2}, 0.0207},
      {"patch-16", {0.00136, 1.85}, {0.00169, 1.1}, 0.0123}, {"patch-24", {0.001, 1.7}, {0.001, 0.7}, 0.00653},
      {"patch-60", {0.0005, 2}, {0.0005, 1}, 0.00253},       {"reference", {0, 0}, {0, 0}, 0.000809},
  };
  return rungs;
}

}  // namespace tactel::host
