#pragma once
#include <string>
#include <vector>

#include "fem/scene.h"

namespace tactel::host {

/// A number of a scene that a sweep may draw: where it stands. `index` for a list such as load.tangential.
using NumberPlace = double& (*)(fem::Scene& scene, int index);

/// The place of "sensor.poisson", "indenter.radius", "contact.friction", "load.tangential", ... in a scene of this
/// indenter shape ("parabola", ...); null where that key cannot be drawn.
NumberPlace number_place(const std::string& key, const std::string& shape);

/// The keys of a table ("sensor", ...) that can be drawn; of the shape's own for "indenter".
std::vector<std::string> drawable_keys(const std::string& table, const std::string& shape);

}  // namespace tactel::host
