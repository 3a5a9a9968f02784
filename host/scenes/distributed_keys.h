// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "fem/scene.h"

namespace tactel::host {

/// Address of a number of a scene that a sweep may draw. `index` is the position in a list such as
/// load.tangential.
using NumberPlace = double& (*)(fem::Scene& scene, int index);

/// Returns the address of "sensor.poisson", "indenter.radius", "contact.friction", "load.tangential", ... in a
/// scene of this indenter shape ("parabola", ...). Returns null where that key cannot be drawn.
NumberPlace number_place(const std::string& key, const std::string& shape);

/// Returns the keys of a table ("sensor", ...) that can be drawn; for "indenter", those of the shape.
std::vector<std::string> drawable_keys(const std::string& table, const std::string& shape);

}  // namespace tactel::host
