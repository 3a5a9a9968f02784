// Written by `tactel tradeoff --scenes 96 --seed 1998 --planner-source FILE`; do not edit.
// 96 contacts drawn with seed 1998: 8 shapes in turn, -4 to 4 mm off centre, nu 0.3, 0.45, 0.49 or 0.499, mu 0.1
// to 1.5, 0.05 to 0.3 mm deep, eight drags of which one scene in four turns back. Device: basic-skylake-avx512-Intel(R)
// Xeon(R) Processor
#include "host/planner.h"

namespace tactel::host {

std::span<const MeasuredRung> measured_ladder() {
  static constexpr MeasuredRung rungs[] = {
      {"draft", 6.76e+05, 0.0186, 0.334, 1.9, {0.16, 0.0728, 0.017, 0.0118, 0.00709}},
      {"paper", 3.91e+05, 0.0162, 0.334, 2.08, {0.163, 0.0755, 0.0196, 0.0113, 0.00434}},
      {"medium", 4.47e+04, 0.00717, 0.0838, 2.15, {0.224, 0.0508, 0.0146, 0.00974, 0.00284}},
      {"fine", 1.3e+04, 0.00258, 0.0444, 1.61, {0.00258, 0.0574, 0.0144, 0.00363, 0.00161}},
      {"finest", 279, 0.00066, 0.0135, 1, {0.00066, 0.00066, 0.0135, 0.00581, 0.000547}},
  };
  return rungs;
}

}  // namespace tactel::host
