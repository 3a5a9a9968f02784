// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/rubber_layer.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

// Parts of scenes of a line (docs/scenes.md), which the mechanics compute with as they are: lengths in mm, forces in
// N/mm of depth, angles in degrees. Every number has the name, unit and default of its key.

namespace tactel {

/// Finite elements of a mesh. `bbar`: Q4 with mean dilatation (Hughes 1980); `q4`: full 2x2 integration; `q4i`: Q4 with
/// incompatible modes (Taylor, Beresford and Wilson 1976); `q8`: serendipity, 3x3 integration.
enum class Element { bbar, q4, q4i, q8 };
/// Recovery of the stress at the base: from nodal reactions through the consistent mass of the base edge, or from
/// stresses extrapolated from the 2x2 Gauss points and averaged at nodes.
enum class StressRecovery { reaction, element };

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
  std::string file{};        ///< where the points were read; empty: not from a file
};
using Shape = std::variant<Flat, Wedge, Parabola, Cylinder, Exponential, Trapezoid, RoundedFlat, Taylor, Profile>;

struct Indenter {
  Shape shape = Parabola{};
  double position = 0.0;  ///< mm along the array
};

/// Target of an increment after the indentation.
struct LoadMove {
  double normal = 0.0;      ///< mm or N/mm: as the load has indentation or normal_force
  double tangential = 0.0;  ///< mm along x since first touch
  bool operator==(const LoadMove&) const = default;
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

}  // namespace tactel
