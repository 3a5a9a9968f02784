#include "host/planner.h"
namespace tactel::host {
std::span<const MeasuredRung> measured_ladder() {
  static constexpr MeasuredRung rows[] = {{"draft", 1, 0, 0, 3, {}}, {"paper", 1, 0, 0, 3, {}}, {"medium", 1, 0, 0, 3, {}}, {"fine", 1, 0, 0, 3, {}}, {"finest", 1, 0, 0, 3, {}}};
  return rows;
}
}  // namespace tactel::host
