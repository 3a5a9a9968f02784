// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

#include "fem/pad/pad_scene.h"
#include "host/scenes/scene_source.h"

namespace tactel::host {

/// Returns a warning for each number that looks as if it had another unit, such as a Young's modulus in Pa, and for
/// measured heights that touch at their border or hold a point far from its neighbours; usually none. What is given is
/// solved as it stands.
std::vector<std::string> unit_warnings(const fem::Scene& scene);
std::vector<std::string> unit_warnings(const fem::PadScene& scene);
/// The same of many scenes: of each number the first such scene, "scenes[3]: ...".
std::vector<std::string> unit_warnings(std::span<const fem::Scene> scenes);
std::vector<std::string> unit_warnings(std::span<const fem::PadScene> scenes);
/// The same of a sweep's first contacts and of all its sensors.
std::vector<std::string> unit_warnings(const AnySource& source);

}  // namespace tactel::host
