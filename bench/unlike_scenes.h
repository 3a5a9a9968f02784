// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/studies/tradeoff/scene_mix.h"

namespace tactel::host {

/// Scenes unlike the mix in one respect.
enum class Unlike { thickness, length, poisson, tactels, force, profile, ends, thin, slippery, over_end };

struct UnlikeClass {
  const char *name, *description;
  Unlike respect;
};
inline constexpr UnlikeClass all_unlike[] = {{"thickness", "rubber 0.5 to 4 mm thick", Unlike::thickness},
                                             {"length", "sensors 8 to 60 mm long", Unlike::length},
                                             {"poisson", "nu from 0 to 0.4999", Unlike::poisson},
                                             {"tactels", "4 to 64 tactels, up to 0.5 mm wide", Unlike::tactels},
                                             {"force", "given forces, 0.01 to 0.6 N/mm", Unlike::force},
                                             {"profile", "measured profiles of 3 to 30 points", Unlike::profile},
                                             {"ends", "indenters 0.1 to 3 mm from an end", Unlike::ends},
                                             {"thin", "5 to 60 thicknesses to a side, nu 0.49 to 0.5", Unlike::thin},
                                             {"slippery", "mu 0.02 to 0.1", Unlike::slippery},
                                             {"over_end", "over an end, nu 0 to 0.48", Unlike::over_end}};

/// Returns scenes of the mix, changed in one respect: thickness (depths in proportion), length, nu between 0 and
/// 0.4999, number, span and width of tactels, a given force, a measured profile, the last 3 mm before an end, a
/// contact 5 to 60 thicknesses to a side at nu 0.49 to 0.5, mu 0.02 to 0.1, or a contact over an end.
std::vector<fem::Scene> unlike_scenes(Unlike respect, std::uint64_t seed, std::size_t count);

}  // namespace tactel::host
