// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"

namespace tactel::host {

/// Returns a scene as in its file, with every default filled in (of a measured profile: its file and its points; of a
/// height map: its file).
nlohmann::ordered_json to_json(const fem::Scene& scene);
nlohmann::ordered_json to_json(const fem::PadScene& scene);

/// Returns the file of a scene, with every default filled in. Throws ConfigError for points of a measured profile that
/// no file holds.
std::string scene_toml(const fem::Scene& scene);
std::string scene_toml(const fem::PadScene& scene);

}  // namespace tactel::host
