// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/error.h>
#include <tactel/export.h>
#include <tactel/line_scene.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

// Scenes as in scene files (docs/scenes.md): lengths in mm, stresses in MPa, forces in N/mm of depth, angles in
// degrees. Every number has the name, unit and default of its key.

namespace tactel {

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
  double thickness = 1.5;               ///< mm; left out beside layers, as young and poisson
  double young = 2.0;                   ///< MPa
  double poisson = 0.45;                ///< 0 <= poisson < 0.5
  int tactels = 21;                     ///< equally spaced
  std::optional<double> tactel_span{};  ///< mm from the middle of the first to that of the last; none: all that fits
  double tactel_width = 0;              ///< mm over which a tactel averages the stress; 0: a point
  std::optional<Mesh> mesh{};           ///< none: contact on the scene's own patch of elements
  std::vector<RubberLayer> layers{};    ///< from the base up, at most 8; none: one, of the numbers above
};

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
/// Returns the scene file of a scene, with every default filled in. Throws InputError for points of a profile that no
/// file holds.
TACTEL_API std::string toml(const Scene& scene);
/// Returns the heights of an indenter above its lowest point at places x [n] mm along the array; infinite where there
/// is no indenter.
TACTEL_API std::vector<double> heights(const Indenter& indenter, const std::vector<double>& x);

}  // namespace tactel
