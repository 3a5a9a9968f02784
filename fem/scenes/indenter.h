// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/line_scene.h>

#include <Eigen/Dense>

namespace tactel::fem {

using tactel::Cylinder, tactel::Exponential, tactel::Flat, tactel::Indenter, tactel::Parabola, tactel::Profile,
    tactel::RoundedFlat, tactel::Shape, tactel::Taylor, tactel::Trapezoid, tactel::Wedge;

/// Throws ValueError, key "indenter.<member>".
void validate(const Indenter& indenter);

/// Returns the height of the profile above its lowest point at x [mm]; +infinity beyond the indenter. An edge
/// extends `edge_guard` beyond its nominal position, so that a node on it touches for any rounding.
double profile_height(const Indenter& indenter, double x);
/// The same at many positions, [n] mm. The hull of a measured profile is built once.
Eigen::VectorXd profile_heights(const Indenter& indenter, const Eigen::VectorXd& x);
inline constexpr double edge_guard = 1e-9;  // mm

/// Lowest part of a profile, mm along the array; infinite ends for a flat without half_width.
struct Interval {
  double left, right;
};
Interval lowest_part(const Indenter& indenter);

/// Returns "flat", "wedge", ... as in scene files.
const char* shape_name(const Shape& shape);

}  // namespace tactel::fem
