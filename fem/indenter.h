// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace tactel::fem {

// Profiles of a rigid indenter: height y [mm] above its lowest point at distance r = |x - position| [mm].

/// 0 up to half_width, no indenter beyond. Without half_width: wider than the sensor.
struct Flat {
  std::optional<double> half_width;  ///< mm
};
/// y = r / tan(edge_angle / 2).
struct Wedge {
  double edge_angle = 120.0;  ///< full angle in degrees, above 0 and below 180
};
/// y = r^2 / (2 radius).
struct Parabola {
  double radius = 10.0;  ///< mm
};
/// y = radius - sqrt(radius^2 - r^2), no indenter beyond r = radius.
struct Cylinder {
  double radius = 10.0;  ///< mm
};
/// y = height (e^(rate r) - 1).
struct Exponential {
  double height = 0.1;  ///< mm
  double rate = 0.5;    ///< 1/mm
};
/// 0 up to half_width, then slope (r - half_width).
struct Trapezoid {
  double half_width = 2.0;  ///< mm
  double slope = 1.0;       ///< height over distance
};
/// 0 up to half_width, then (r - half_width)^2 / (2 radius).
struct RoundedFlat {
  double half_width = 2.0, radius = 10.0;  ///< mm
};
/// y = height * sum of c_k (r / scale)^k over the powers; no powers: flat.
struct Taylor {
  std::vector<int> powers;             ///< each 1 or more
  double scale = 1.0;                  ///< mm
  std::optional<double> height{};      ///< mm; none: scale
  std::vector<double> coefficients{};  ///< [powers] c_k, none below 0 so that the profile is convex; empty: all 1
};
/// Measured: linear between the points, no indenter beyond the ends. Heights count from the lowest point.
struct Profile {
  std::vector<double> x, y;  ///< mm, x increasing; x is measured from the indenter's position
  double smooth = 0.0;       ///< mm: largest non-convexity that is accepted (and lifted to the lower convex hull)
  std::string file;          ///< source of the points, for messages
};
using Shape = std::variant<Flat, Wedge, Parabola, Cylinder, Exponential, Trapezoid, RoundedFlat, Taylor, Profile>;

struct Indenter {
  Shape shape = Parabola{};
  double position = 0.0;  ///< mm along the array
  void validate() const;  ///< throws ValueError, key "indenter.<member>"
};

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
