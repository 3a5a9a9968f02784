// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "fem/pad/pad_scene.h"

namespace tactel::host {

/// Returns a pad's scene as in its file, with every default filled in (of a height map: its file).
nlohmann::ordered_json to_json(const fem::PadScene& scene);

}  // namespace tactel::host
