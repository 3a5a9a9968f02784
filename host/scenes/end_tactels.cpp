// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/end_tactels.h"

#include <algorithm>

namespace tactel::host {

bool tactels_at_ends(const fem::Sensor& sensor) {
  return sensor.tactels > 1 && sensor.tactel_width == 0 && sensor.span() > sensor.length * (1 - 1e-6);
}

bool tactels_at_ends(const SceneSource& source) {
  return std::ranges::any_of(source.sensors(), [](const fem::Sensor& sensor) { return tactels_at_ends(sensor); });
}

}  // namespace tactel::host
