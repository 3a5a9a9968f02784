// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/pad_scene.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "fem/scenes/indenter.h"

namespace tactel::fem {

// A pad is a layer of rubber, bonded to a rigid base, with tactels in two directions. x and y lie in its plane with 0
// in its middle, z points up from the base. An indenter presses it, drags it along x and y and turns about z.

using PadSensor = Pad;
using tactel::Sides;
const char* name(Sides sides);  ///< "free", "held"
/// Throws ValueError, key "sensor.<member>".
void validate(const PadSensor& sensor);
/// Returns how far the skin lies below its middle at a place, mm: (x^2 + y^2) / (2 curvature_radius); 0 where it is
/// flat.
double fall_of_skin(const PadSensor& sensor, double x, double y);

// Profiles: height [mm] above the lowest point at (x, y) from the indenter's axis, in the indenter's own frame.

using tactel::Box, tactel::Cone, tactel::LyingCylinder, tactel::Paraboloid, tactel::Punch, tactel::Sphere;
/// Measured: bilinear between heights on a grid whose middle is the axis; no indenter beyond it.
struct HeightMap {
  double pitch = 0.1;       ///< mm
  Eigen::MatrixXd heights;  ///< [along x][along y] mm above the lowest, which is 0
  std::string file{};       ///< where it was read; empty: not from a file
};
using PadShape = PadShapes<HeightMap>;

/// Returns the name of a shape in scene files: "sphere".
const char* shape_name(const PadShape& shape);
/// Whether an indenter of this shape, with a flat bottom, may be tilted.
bool tilts(const PadShape& shape);
/// How a shape ends: nowhere, at the ends of a lying cylinder, at a flat bottom's edge, at a map's border.
enum class PadEdge { none, ends, sharp, rounded, measured };
PadEdge pad_edge(const PadShape& shape);
/// Throws ValueError, key "indenter.<member>".
void check_shape(const PadShape& shape);
/// The same unless 1e-6 <= value <= 1e6: any product with others is finite.
void check_length(const char* member, double value, const char* allowed = "a length in mm, between 1e-6 and 1e6");

struct PadIndenter {
  PadShape shape = Sphere{};
  std::array<double, 2> position = {0, 0};  ///< mm: its axis on the pad
  double yaw = 0;                           ///< degrees, of its own frame about z
  double tilt = 0,
         tilt_direction = 0;  ///< degrees, of a punch or box: its bottom rises along this direction of its own frame
  std::optional<double> young{};  ///< MPa, of an elastic object (SoftObject); none: rigid
  double poisson = 0.45;          ///< of an elastic object
  // Over a curved skin, as the cells see it (over_skin):
  double curvature = 0;  ///< 1/mm, of the skin about the pad's middle
  double touch = 0;      ///< mm: the least height above the skin, which is counted from there

  void validate() const;  ///< throws ValueError, key "indenter.<member>"
};

/// Whether every turn about z serves an indenter alike.
bool is_round(const PadIndenter& indenter);

/// Returns an indenter whose heights are those above the skin of a pad, which may be curved, from first touch on.
PadIndenter over_skin(PadIndenter indenter, const PadSensor& sensor);

/// Returns the height at (x, y) of the own frame, mm; +infinity beyond the indenter. With `beyond_edges` the bottom
/// goes on beyond sharp edges.
double pad_height(const PadIndenter& indenter, double x, double y, bool beyond_edges = false);

/// Returns heights at every x with every y, [x][y] mm: as pad_height beyond edges, but for rounding.
Eigen::MatrixXd pad_heights(const PadIndenter& indenter, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y);

/// A rectangle, mm; of the own frame where nothing else is said.
struct PadBox {
  Interval x, y;

  void cover(const PadBox& other) {
    x = {std::min(x.left, other.x.left), std::max(x.right, other.x.right)};
    y = {std::min(y.left, other.y.left), std::max(y.right, other.y.right)};
  }
};
inline constexpr Interval nowhere{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

inline constexpr PadBox everywhere{{nowhere.right, nowhere.left}, {nowhere.right, nowhere.left}};

/// Returns the indenter's own edges, of a map its border: infinite where it has none.
PadBox pad_edges(const PadShape& shape);

/// Returns a box around where the rigid profile lies below a depth, mm.
PadBox rigid_section(const PadIndenter& indenter, double depth);

/// Position of the indenter after an increment: `normal` is the depth, mm, or P, N.
struct PadTarget {
  double normal = 0;
  double x = 0, y = 0;  ///< mm along the pad since first touch
  double twist = 0;     ///< rad about the axis since first touch
};

/// The pressing, then the drags.
struct PadLoad {
  std::vector<double> indentation{0.2};  ///< mm: targets, each reached in indentation_steps equal increments
  std::vector<double> normal_force{};    ///< N: instead of indentation
  int indentation_steps = 1;
  std::vector<std::array<double, 3>>
      drags;                     ///< successive positions x, y (mm) and twist (rad), at the last normal target
  std::vector<PadTarget> moves;  ///< instead of the drags: one increment each, normal target and position together
  std::vector<double> times{};   ///< s: of each target, of rubber that creeps; empty: none

  void validate() const;  ///< throws ValueError, key "load.<member>"
};

/// One contact on a pad.
struct PadScene {
  std::string title;
  PadSensor sensor;
  PadIndenter indenter;
  double friction = 0.5;  ///< mu; with a map its largest
  PadLoad load;
  std::optional<Markers> markers{};
  std::optional<Camera> camera{};
  std::optional<FrictionMap> friction_map{};
  void validate() const;
  void set_friction(FrictionMap map);
};

/// Returns mu at places on the pad, [places] mm.
Eigen::VectorXd friction_at(const PadScene& scene, const Eigen::MatrixX2d& places);
/// Returns "0.5", or "0.5 at most" of a map.
std::string friction_text(const PadScene& scene);
/// Throws ValueError for rubber that creeps under a load without times.
void require_times(const PadScene& scene);

inline constexpr std::size_t most_pad_targets = 1000;  ///< increments of pressing that a load may ask for

inline bool by_force(const PadScene& scene) { return !scene.load.normal_force.empty(); }

/// Returns the targets that the load asks for, in order; the first `pressing_targets` press at the first place.
std::vector<PadTarget> pad_targets(const PadLoad& load);
std::size_t pressing_targets(const PadLoad& load);
/// Returns the largest normal target of the load.
double largest_normal(const PadLoad& load);

}  // namespace tactel::fem
