#pragma once
#include <string>
#include <vector>

#include "fem/scene.h"

namespace tactel::host {

struct ExtremeScene {
  std::string group, name;
  fem::Scene scene;
};

/// The scenes of the table of extremes: one quantity at a time goes to its ends. `finest`: with the mesh of 401 x 101.
std::vector<ExtremeScene> extreme_scenes(bool finest);

/// What they go out from: a parabola on mesh B, pressed in, dragged forth until it nearly slides, and back.
fem::Scene ordinary_scene();

}  // namespace tactel::host
