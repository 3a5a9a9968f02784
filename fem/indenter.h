#pragma once
#include <Eigen/Dense>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace tactel::fem {

// Profiles of a rigid indenter: height y [mm] above its lowest point at distance r = |x - position| [mm].
struct Flat {
  std::optional<double> half_width;
};  ///< 0 up to half_width, nothing beyond; no half_width: wider than the sensor
struct Wedge {
  double edge_angle = 120.0;
};  ///< full angle in degrees, 0 < edge_angle < 180: y = r / tan(edge_angle / 2)
struct Parabola {
  double radius = 10.0;
};  ///< y = r^2 / (2 radius)
struct Cylinder {
  double radius = 10.0;
};  ///< y = radius - sqrt(radius^2 - r^2), nothing beyond r = radius
struct Exponential {
  double height = 0.1, rate = 0.5;
};  ///< y = height (e^(rate r) - 1), rate in 1/mm
struct Trapezoid {
  double half_width = 2.0, slope = 1.0;
};  ///< 0, then slope (r - half_width)
struct RoundedFlat {
  double half_width = 2.0, radius = 10.0;
};  ///< 0, then (r - half_width)^2 / (2 radius)
struct Taylor {
  std::vector<int> powers;
  double scale = 1.0;            ///< mm
  std::optional<double> height{};  ///< mm: y = height * sum (r / scale)^k; none: scale
};                ///< y = scale * sum (r / scale)^k, k >= 1; no powers: flat
struct Profile {  ///< measured: linear between points, nothing beyond the ends; height above the lowest point
  std::vector<double> x, y;  ///< mm, x increasing; x is measured from the indenter's position
  double smooth = 0.0;       ///< mm: largest non-convexity that is accepted (and lifted to the lower convex hull)
  std::string file;          ///< where the points came from, for messages
};
using Shape = std::variant<Flat, Wedge, Parabola, Cylinder, Exponential, Trapezoid, RoundedFlat, Taylor, Profile>;

struct Indenter {
  Shape shape = Parabola{};
  double position = 0.0;  ///< mm along the array
  void validate() const;  ///< throws ValueError, key "indenter.<member>"
};

/// Height of the profile above its lowest point at x [mm]; +infinity where there is no indenter. An edge reaches
/// `edge_guard` further than its number says, so that a node that stands on it touches whatever the rounding.
double profile_height(const Indenter& indenter, double x);
/// The same at many places, [n] mm; a measured profile's hull is built once.
Eigen::VectorXd profile_heights(const Indenter& indenter, const Eigen::VectorXd& x);
inline constexpr double edge_guard = 1e-9;  // mm

/// Where the profile is lowest, mm along the array; infinite ends for a flat without half_width.
struct Interval {
  double left, right;
};
Interval lowest_part(const Indenter& indenter);

/// "flat", "wedge", ... as in scene files.
const char* shape_name(const Shape& shape);

}  // namespace tactel::fem
