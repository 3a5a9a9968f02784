// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "fem/scene.h"

namespace tactel::host {

struct ExtremeScene {
  std::string group, name;
  fem::Scene scene;
};

/// Returns the scenes of the table of extremes: one quantity at a time takes its extreme values. `finest`: with
/// the mesh of 401 x 101.
std::vector<ExtremeScene> extreme_scenes(bool finest);

/// Returns the scene that the extremes vary: a parabola on mesh B, pressed in, dragged until it nearly slides, and
/// back.
fem::Scene ordinary_scene();

}  // namespace tactel::host
