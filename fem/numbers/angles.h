// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <numbers>

namespace tactel::fem {

// Angles are degrees in files and answers, radians in computations.

inline double radians(double degrees) { return degrees * std::numbers::pi / 180; }
inline double degrees(double radians) { return radians * 180 / std::numbers::pi; }
/// Without what turning degrees into radians and back leaves: to 1e-9 degrees.
inline double clean_degrees(double radians) { return std::round(degrees(radians) * 1e9) / 1e9; }

}  // namespace tactel::fem
