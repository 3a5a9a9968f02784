// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/scene.h>

#include "fem/scene.h"

namespace tactel::api {

/// Returns the scene as the mechanics have it.
fem::Scene to_fem(const Scene& scene);
fem::Indenter to_fem(const Indenter& indenter);
/// Returns the scene as users have it.
Scene from_fem(const fem::Scene& scene);

/// Throws InputError naming `item` for a scene that the model rejects.
void check_scene(const fem::Scene& scene, const std::string& item = {});
/// Throws ConfigError for what is neither "", "fp32" nor "fp64".
void check_precision(const std::string& precision);

}  // namespace tactel::api
