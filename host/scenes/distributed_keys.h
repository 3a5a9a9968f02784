// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"

namespace tactel::host {

/// Sets a number of a scene that a sweep may draw. `index` is the position in a list such as load.tangential; of
/// positions [[x, y], ...] two to each.
template <class Scene>
using NumberPlace = void (*)(Scene& scene, int index, double value);

/// Returns the place of "sensor.poisson", "indenter.radius", "contact.friction", "load.tangential", ... in a
/// scene of this indenter shape ("parabola", ...). Returns null where that key cannot be drawn.
template <class Scene>
NumberPlace<Scene> number_place(const std::string& key, const std::string& shape);

/// Returns the keys of a table ("sensor", ...) that can be drawn; for "indenter", those of the shape.
template <class Scene>
std::vector<std::string> drawable_keys(const std::string& table, const std::string& shape);

}  // namespace tactel::host
