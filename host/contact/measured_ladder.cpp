#include "host/contact/planner.h"

namespace tactel::host {

std::span<const MeasuredRung> measured_ladder() {
  static constexpr MeasuredRung rungs[] = {
      {"patch-8", 2, 1, 0.017},
      {"patch-12", 2, 1, 0.008},
      {"patch-16", 2, 1, 0.005},
      {"patch-24", 1, 0, 0.003},
      {"reference", 0, 0, 0.001},
  };
  return rungs;
}

}  // namespace tactel::host
