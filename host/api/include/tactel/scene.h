// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/error.h>
#include <tactel/export.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// Scenes as in scene files (docs/scenes.md): lengths in mm, stresses in MPa, forces in N/mm of depth, angles in
// degrees. Every number has the name, unit and default of its key.

namespace tactel {

/// Finite elements of a mesh.
enum class Element { bbar, q4, q4i, q8 };
/// Recovery of the stress at the base.
enum class StressRecovery { reaction, element };

/// Mesh of the rubber layer.
struct Mesh {
  int columns = 41;      ///< nodes along x
  int rows = 11;         ///< nodes through the thickness
  double grading = 4.0;  ///< bottom row height over top row height, geometric in between
  Element element = Element::bbar;
  StressRecovery stress = StressRecovery::reaction;
};

/// The rubber layer and its tactels.
struct Sensor {
  double length = 20.0;                 ///< mm
  double thickness = 1.5;               ///< mm
  double young = 2.0;                   ///< MPa
  double poisson = 0.45;                ///< 0 <= poisson < 0.5
  int tactels = 21;                     ///< equally spaced
  std::optional<double> tactel_span{};  ///< mm from the middle of the first to that of the last; none: all that fits
  double tactel_width = 0;              ///< mm over which a tactel averages the stress; 0: a point
  std::optional<Mesh> mesh{};           ///< none: contact on the scene's own patch of elements
};

// Profiles of a rigid indenter: height y [mm] above its lowest point at distance r = |x - position| [mm].

/// y = r^2 / (2 radius).
struct Parabola {
  double radius = 10.0;  ///< mm
};
/// 0 up to half_width, no indenter beyond. Without half_width: wider than the sensor.
struct Flat {
  std::optional<double> half_width{};  ///< mm
};
/// y = r / tan(edge_angle / 2).
struct Wedge {
  double edge_angle = 120.0;  ///< full angle in degrees
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
/// y = height * sum of c_k (r / scale)^k over the powers.
struct Taylor {
  std::vector<int> powers{1};
  double scale = 1.0;                  ///< mm
  std::optional<double> height{};      ///< mm; none: scale
  std::vector<double> coefficients{};  ///< [powers] c_k; empty: all 1
};
/// Points: linear between them, no indenter beyond the ends.
struct Profile {
  std::vector<double> x, y;  ///< mm, x increasing, counted from the indenter's position
  double smooth = 0.0;       ///< mm: largest non-convexity that is lifted to the convex hull
};
using Shape = std::variant<Parabola, Flat, Wedge, Cylinder, Exponential, Trapezoid, RoundedFlat, Taylor, Profile>;

/// Returns the profile of a function y(x) [mm], sampled at `points` places from `left` to `right` [mm], x counted from
/// the indenter's position. Non-convexities up to 1e-9 mm, the rounding of y, are lifted.
template <class Height>
Profile sampled(const Height& height, double left, double right, int points = 401) {
  Profile profile;
  profile.smooth = 1e-9;
  for (int i = 0; i < points; ++i) {
    const double x = points < 2 ? left : left + (right - left) * i / (points - 1);
    profile.x.push_back(x);
    profile.y.push_back(height(x));
  }
  return profile;
}

struct Indenter {
  Shape shape = Parabola{};
  double position = 0.0;  ///< mm along the array
};

/// Target of an increment after the indentation.
struct LoadMove {
  double normal = 0.0;      ///< mm or N/mm: as the load has indentation or normal_force
  double tangential = 0.0;  ///< mm along x since first touch
};

/// The path of the indenter: a depth or normal force, then a drag.
struct Load {
  std::vector<double> indentation{0.15};  ///< mm: targets, each reached in indentation_steps equal increments
  std::vector<double> normal_force{};     ///< N/mm: instead of indentation
  int indentation_steps = 1;
  std::vector<double> tangential{};       ///< mm: explicit positions after the indentation; or
  double tangential_step = 0.0;           ///< mm: equal steps (0: none)
  std::optional<int> tangential_steps{};  ///< number of them; none with a tangential_step: until the contact slides
  std::optional<double> angle{};          ///< degrees, with normal_force: P and Q = P tan(angle) grow together
  std::vector<LoadMove> moves{};          ///< instead of a drag: one increment each, as irregular sweeps draw them

  /// Return this load with a drag: `steps` equal steps of `step` mm; steps until the whole contact slides; explicit
  /// positions, mm.
  Load drag(double step, int steps) const {
    Load load = *this;
    load.tangential_step = step, load.tangential_steps = steps;
    return load;
  }
  Load drag_until_sliding(double step) const {
    Load load = *this;
    load.tangential_step = step, load.tangential_steps.reset();
    return load;
  }
  Load drag_to(std::vector<double> positions) const {
    Load load = *this;
    load.tangential = static_cast<std::vector<double>&&>(positions);
    return load;
  }
};

/// Returns the load that presses to `depth` mm in equal steps.
inline Load press(double depth, int steps = 1) {
  Load load;
  load.indentation = {depth}, load.indentation_steps = steps;
  return load;
}
/// Returns the load of a normal force, N/mm, in equal steps.
inline Load press_by_force(double normal_force, int steps = 1) {
  Load load;
  load.indentation.clear();
  load.normal_force = {normal_force}, load.indentation_steps = steps;
  return load;
}
/// Returns the load of a force at an angle [degrees]: P and Q = P tan(angle) grow together.
inline Load force_at_angle(double normal_force, double angle, int steps = 1) {
  Load load = press_by_force(normal_force, steps);
  load.angle = angle;
  return load;
}

/// Friction of a contact whose nodes stick until they lift off.
inline constexpr double bonded = std::numeric_limits<double>::infinity();

/// One contact.
struct Scene {
  std::string title{};
  Sensor sensor{};
  Indenter indenter{};
  double friction = 0.5;  ///< mu >= 0, or bonded
  Load load{};
};

/// Reads a scene file (TOML). Throws InputError with file, line, key, value and what is allowed.
TACTEL_API Scene read_scene(const std::string& path);
/// Throws InputError for the first value that the model rejects.
TACTEL_API void validate(const Scene& scene);
/// Returns the heights of an indenter above its lowest point at places x [n] mm along the array; infinite where there
/// is no indenter.
TACTEL_API std::vector<double> heights(const Indenter& indenter, const std::vector<double>& x);

}  // namespace tactel
