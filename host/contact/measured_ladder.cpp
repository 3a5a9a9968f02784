// Written by `tactel tradeoff --scenes 96 --seed 1998 --planner-source FILE`; do not edit.
// 96 contacts drawn with seed 1998: 8 shapes in turn, -4 to 4 mm off centre, nu 0.3, 0.45, 0.49 or 0.499, mu 0.1
// to 1.5, 0.05 to 0.3 mm deep, eight drags of which one scene in four turns back. Device: basic-skylake-avx512-Intel(R)
// Xeon(R) Processor
#include "host/contact/planner.h"

namespace tactel::host {

std::span<const MeasuredRung> measured_ladder() {
  static constexpr MeasuredRung rungs[] = {
      {"draft", 3.2e+06, 0.0161, 0.334, 2.03, {0.163, 0.0757, 0.0191, 0.0108, 0.00483}},
      {"paper", 1.9e+06, 0.0162, 0.334, 2.1, {0.163, 0.0755, 0.0196, 0.0113, 0.00434}},
      {"medium", 2.38e+05, 0.0074, 0.0838, 2.08, {0.222, 0.0505, 0.0144, 0.00979, 0.00276}},
      {"fine", 5.11e+04, 0.00258, 0.0443, 1.62, {0.00258, 0.0574, 0.0144, 0.00364, 0.00163}},
      {"finest", 1.1e+03, 0.000661, 0.0135, 1, {0.000661, 0.000661, 0.0135, 0.00581, 0.000547}},
  };
  return rungs;
}

}  // namespace tactel::host
