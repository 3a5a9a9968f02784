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

/// Returns a description of `mixed_scenes`, for reports.
std::string mix_description(std::uint64_t seed, std::size_t count);

}  // namespace tactel::host
