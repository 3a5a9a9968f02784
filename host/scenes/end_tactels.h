// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/scenes/scene_source.h"

namespace tactel::host {

/// Returns true where the outermost tactels are points at the ends of the glued base, where the exact stress is
/// infinite: what they read depends on the model. Tactels of a width read a finite mean.
bool tactels_at_ends(const fem::Sensor& sensor);
/// The same of any sensor of a sweep.
bool tactels_at_ends(const SceneSource& source);

/// What commands say of such tactels, where contacts are solved on patches.
inline constexpr const char* tactels_at_ends_text =
    "the outermost tactels stand at the ends of the glued base, where the exact stress is infinite: what a network "
    "learns from them is the model's; sensor.tactel_span or sensor.tactel_width avoids it (docs/sweeps.md)";

}  // namespace tactel::host
