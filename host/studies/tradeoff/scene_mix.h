// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "fem/scenes/scene.h"

namespace tactel::host {

/// Numbers that are the same wherever the program was built, unlike those of std::uniform_real_distribution.
class SceneDraw {
 public:
  SceneDraw(std::uint64_t seed, std::size_t place) : random_(seed * 1000003 + place) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }

 private:
  std::mt19937_64 random_;
};

inline constexpr std::size_t mix_kinds = 8;  ///< of indenter, in turn

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
