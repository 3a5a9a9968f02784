// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/rubber_layer.h>

#include <array>
#include <optional>
#include <variant>
#include <vector>

// Parts of scenes of a pad (docs/pads.md), which the mechanics compute with as they are: lengths in mm, stresses in
// MPa, angles in degrees. Every number has the name, unit and default of its key.

namespace tactel {

/// Sides of a pad whose length and width are given: `free` of stress, or `held`, as if the rubber went on without end.
enum class Sides { free, held };

/// The rubber and its tactels.
struct Pad {
  std::array<int, 2> tactels{4, 4};          ///< along x and y
  std::array<double, 2> pitch{4.7, 4.7};     ///< mm, from tactel to tactel; the array is centred
  double tactel_size = 0;                    ///< mm: side of the square over which a tactel takes the mean; 0: a point
  int axes = 3;                              ///< 3, or 1: tactels that measure the normal stress alone
  double thickness = 2.0;                    ///< mm; with layers their sum
  double young = 2.0;                        ///< MPa; with layers that of the uppermost
  double poisson = 0.45;                     ///< 0 <= poisson <= 0.5; with layers that of the uppermost
  std::optional<double> length{}, width{};   ///< mm: the rubber along x and y; none: not known
  Sides sides = Sides::free;                 ///< where length and width are given; else they are held
  std::optional<double> curvature_radius{};  ///< mm, of the skin, which stands out in its middle; none: flat
  std::vector<RubberLayer> layers{};         ///< from the base up, at most 8; none: one, of the numbers above
  /// Shares of E that relax, above 0 and below 1 in all, and their times, s, which differ; at most 4. None: elastic.
  std::vector<std::array<double, 2>> relaxation{};
  double depth = 0;  ///< mm of the tactels above the base, at most three quarters of the thickness
  bool operator==(const Pad&) const = default;
};

/// The same for a pad in braces.
inline Pad with_layers(Pad pad) { return with_layers<Pad>(static_cast<Pad&&>(pad)); }

/// Coulomb's mu over the skin of a pad, in place of one number: on a grid about the pad's middle, bilinear between
/// nodes, constant beyond the outermost.
struct FrictionMap {
  std::vector<std::vector<double>> rows{};  ///< [along y][along x] 0 to 100; 1 to 64 along each
  double pitch = 1.0;                       ///< mm, from node to node
  bool operator==(const FrictionMap&) const = default;
};

/// Marks within the rubber of a pad, which move with it. They lie on a grid about the pad's middle, or at places.
struct Markers {
  std::array<int, 2> counts{9, 7};              ///< along x and y
  std::array<double, 2> pitch{1.0, 1.0};        ///< mm, from marker to marker
  double depth = 0.25;                          ///< mm below the surface: 0 <= depth < thickness
  std::vector<std::array<double, 2>> places{};  ///< mm on the pad, in place of counts and pitch
  bool operator==(const Markers&) const = default;
};

/// A pinhole camera below the middle of a pad, which looks up at its markers through the rubber.
struct Camera {
  double distance = 20.0;              ///< mm, from the pinhole to the plane of the markers
  double pixels_per_mm = 20.0;         ///< in that plane
  std::array<double, 2> centre{0, 0};  ///< pixels: image of the pad's middle
  double noise_px = 0;                 ///< standard deviation along each axis in sets; `solve` has none
  bool operator==(const Camera&) const = default;
};

// Shapes of an indenter: height [mm] above its lowest point at (x, y) from its axis, r = |(x, y)| [mm].

/// radius - sqrt(radius^2 - r^2), no indenter beyond r = radius.
struct Sphere {
  double radius = 8.0;  ///< mm
};
/// x^2 / (2 radii[0]) + y^2 / (2 radii[1]).
struct Paraboloid {
  std::array<double, 2> radii{10.0, 10.0};  ///< mm
};
/// A cylinder along y: radius - sqrt(radius^2 - x^2), no indenter beyond |x| = radius and |y| = half_length.
struct LyingCylinder {
  double radius = 8.0, half_length = 4.0;  ///< mm
};
/// max(0, r - radius)^2 / (2 edge); edge 0: sharp, no indenter beyond the radius.
struct Punch {
  double radius = 2.0, edge = 0.0;  ///< mm
};
/// The sum of max(0, |x| - half_widths[0])^2 / (2 edge) and the same along y; edge 0: sharp.
struct Box {
  std::array<double, 2> half_widths{2.0, 2.0};  ///< mm
  double edge = 0.0;                            ///< mm
};
/// r / tan(angle).
struct Cone {
  double angle = 75.0;  ///< degrees between surface and axis, above 0 and below 90
};
/// All shapes; `Map`: measured heights.
template <class Map>
using PadShapes = std::variant<Sphere, Paraboloid, LyingCylinder, Punch, Box, Cone, Map>;

}  // namespace tactel
