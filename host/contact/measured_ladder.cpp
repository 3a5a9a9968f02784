// Written by `tactel tradeoff --scenes 96 --seed 1998 --planner-source FILE`; do not edit.
// 96 contacts drawn with seed 1998: 8 shapes in turn, -4 to 4 mm off centre, nu 0.3, 0.45, 0.49 or 0.499, mu 0.1
// to 1.5, 0.05 to 0.3 mm deep, eight drags, reversed in one scene of four. Device: basic-skylake-avx512-Intel(R)
// Xeon(R) Processor
#include "host/contact/planner.h"

namespace tactel::host {

std::span<const MeasuredRung> measured_ladder() {
  static constexpr MeasuredRung rungs[] = {
      {"patch-8", 2.34, 1.61, 0.0121}, {"patch-12", 2.23, 2.63, 0.00661}, {"patch-16", 2.69, 2.27, 0.0042},
      {"patch-24", 1, 0, 0.00203},     {"reference", 0, 0, 0.00103},
  };
  return rungs;
}

}  // namespace tactel::host
