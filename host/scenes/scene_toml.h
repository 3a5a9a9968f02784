// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"

namespace tactel::host {

/// Returns the file of a scene, with every default filled in. Throws ConfigError for points of a measured profile that
/// no file holds.
std::string scene_toml(const fem::Scene& scene);
std::string scene_toml(const fem::PadScene& scene);

}  // namespace tactel::host
