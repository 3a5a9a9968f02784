#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "fem/scene.h"

namespace tactel::host {

/// The mix of contacts on which rungs of the ladder are judged (host/ladder.h): eight kinds of indenter from ones that
/// touch a single node of mesh B to ones that cover half the sensor, anywhere between -4 and 4 mm; nu 0.3, 0.45, 0.49
/// and 0.499; mu 0.1 to 1.5; 0.05 to 0.3 mm deep (3 to 20 % of the rubber); drags that end between a fifth of the way
/// to sliding and beyond it, one in four with a way back. On the default sensor; what is drawn depends on seed and
/// place alone, so that a smaller mix is the beginning of a larger one.
std::vector<fem::Scene> mixed_scenes(std::uint64_t seed, std::size_t count);

/// What `mixed_scenes` means, for reports.
std::string mix_description(std::uint64_t seed, std::size_t count);

}  // namespace tactel::host
