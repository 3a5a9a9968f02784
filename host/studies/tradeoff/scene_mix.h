// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "fem/scene.h"

namespace tactel::host {

/// Returns the mix of contacts on which rungs of the ladder are judged (host/scenes/ladder.h). It has eight kinds
/// of indenter at positions between -4 and 4 mm. The sharpest touch a single node of mesh B, the widest cover
/// half the sensor. nu is 0.3, 0.45, 0.49 or 0.499, mu 0.1 to 1.5, the depth 0.05 to 0.3 mm (3 to 20 % of the
/// rubber). Drags end between a fifth of the way to sliding and beyond it; one in four reverses. The sensor is
/// the default. A contact depends on seed and index alone, so that a smaller mix is the beginning of a larger
/// one.
std::vector<fem::Scene> mixed_scenes(std::uint64_t seed, std::size_t count);

/// Scenes unlike the mix in one respect.
enum class Unlike { thickness, length, poisson, tactels, force, profile, ends, thin, slippery, over_end };
inline constexpr Unlike all_unlike[] = {Unlike::thickness, Unlike::length,  Unlike::poisson, Unlike::tactels,
                                        Unlike::force,     Unlike::profile, Unlike::ends,    Unlike::thin,
                                        Unlike::slippery,  Unlike::over_end};

/// Returns "rubber 0.5 to 4 mm thick" and its like.
const char* description(Unlike respect);

/// Returns scenes of the mix, changed in one respect: thickness (depths in proportion), length, nu between 0 and
/// 0.4999, number, span and width of tactels, a given force, a measured profile, the last 3 mm before an end, a
/// contact 5 to 60 thicknesses to a side at nu 0.49 to 0.5, mu 0.02 to 0.1, or a contact over an end.
std::vector<fem::Scene> unlike_scenes(Unlike respect, std::uint64_t seed, std::size_t count);

/// Returns a description of `mixed_scenes`, for reports.
std::string mix_description(std::uint64_t seed, std::size_t count);

}  // namespace tactel::host
