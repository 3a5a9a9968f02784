// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/pad_scene.h>
#include <tactel/solve.h>

// Contacts on a pad, a layer of rubber with tactels in two directions, as in scene files of pads (docs/pads.md):
// lengths in mm, stresses in MPa, forces in N, angles in degrees. x and y lie in the plane with 0 in the pad's middle,
// z points up from the base. Every number has the name, unit and default of its key.

namespace tactel {

/// Heights on a grid whose middle is the axis: bilinear between them, no indenter beyond. The lowest counts as 0.
struct HeightMap {
  double pitch = 0.1;             ///< mm, from point to point
  std::size_t columns = 0;        ///< points along x
  std::vector<double> heights{};  ///< [rows along y][columns] mm
};
using PadShape = PadShapes<HeightMap>;

struct PadIndenter {
  PadShape shape = Sphere{};
  std::array<double, 2> position{};  ///< mm: its axis on the pad
  double yaw = 0;                    ///< degrees that the shape is turned about z
  double tilt = 0;                   ///< degrees, of Punch and Box: the bottom rises along tilt_direction
  double tilt_direction = 0;         ///< degrees, from x of the turned shape
  std::optional<double> young{};     ///< MPa, of an elastic object; none: rigid
  double poisson = 0.45;             ///< of an elastic object
};

/// The path of the indenter: a depth or normal force, then drags with twists about the indenter's axis.
struct PadLoad {
  std::vector<double> indentation{0.2};             ///< mm: targets, each reached in indentation_steps equal increments
  std::vector<double> normal_force{};               ///< N: instead of indentation
  int indentation_steps = 1;                        ///< increments of each target
  std::vector<std::array<double, 2>> tangential{};  ///< mm: successive positions (x, y) after the pressing
  std::vector<double> twist{};                      ///< degrees at these positions; empty: 0
  /// An increment to a depth (mm) or force (N), a position (mm) and a twist (degrees).
  struct Move {
    double normal = 0;
    std::array<double, 2> tangential{};
    double twist = 0;
  };
  std::vector<Move> moves{};    ///< instead of drags, as irregular sweeps draw them
  std::vector<double> times{};  ///< s: of each load step, of a pad that relaxes

  /// Return this load with more drags: `steps` equal steps of `step` mm and `twist_step` degrees; to explicit
  /// positions, mm, and twists, degrees. Throw InputError for more than 100000 steps.
  PadLoad drag(std::array<double, 2> step, int steps, double twist_step = 0) const {
    if (steps < 0 || steps > 100000) throw InputError("steps", std::to_string(steps), "must be 0 to 100000 drags");
    const std::array<double, 2> from = tangential.empty() ? std::array{0.0, 0.0} : tangential.back();
    const double turned = twist.empty() ? 0 : twist.back();
    PadLoad load = *this;
    load.twist.resize(tangential.size());
    for (int k = 1; k <= steps; ++k) {
      load.tangential.push_back({from[0] + k * step[0], from[1] + k * step[1]});
      load.twist.push_back(turned + k * twist_step);
    }
    return load;
  }
  PadLoad drag_to(const std::vector<std::array<double, 2>>& positions, const std::vector<double>& twists = {}) const {
    PadLoad load = *this;
    load.twist.resize(tangential.size());
    load.tangential.insert(load.tangential.end(), positions.begin(), positions.end());
    load.twist.insert(load.twist.end(), twists.begin(), twists.end());
    if (twists.empty()) load.twist.resize(load.tangential.size());
    return load;
  }
  /// Returns this load with `steps` equal twists of `twist_step` degrees in place.
  PadLoad turn(double twist_step, int steps) const { return drag({0, 0}, steps, twist_step); }
};

/// Returns the load that presses a pad to `depth` mm in equal steps.
inline PadLoad press_pad(double depth, int steps = 1) { return {.indentation = {depth}, .indentation_steps = steps}; }
/// Returns the load of a normal force on a pad, N, in equal steps.
inline PadLoad press_pad_by_force(double normal_force, int steps = 1) {
  return {.indentation = {}, .normal_force = {normal_force}, .indentation_steps = steps};
}

/// One contact on a pad.
struct PadScene {
  std::string title{};
  Pad sensor{};
  PadIndenter indenter{};
  double friction = 0.5;  ///< mu, 0 to 100; left out where there is a map
  PadLoad load{};
  std::optional<Markers> markers{};           ///< none: answers have no displacements of markers
  std::optional<Camera> camera{};             ///< of markers; none: answers have no pixels
  std::optional<FrictionMap> friction_map{};  ///< none: one mu
};

/// Reads the scene file of a pad (TOML). Throws InputError with file, line, key, value and what is allowed.
TACTEL_API PadScene read_pad_scene(const std::string& path);
/// Reads a scene file of either kind.
TACTEL_API std::variant<Scene, PadScene> read_any_scene(const std::string& path);
/// Throws InputError for the first value that the model rejects.
TACTEL_API void validate(const PadScene& scene);
TACTEL_API std::string toml(const PadScene& scene);

/// Residual of the contact laws in a step; all relative.
struct PadResidual {
  double penetration = 0, complementarity = 0, cone = 0, drift = 0, angle = 0;
};

/// The state at the end of a load increment. Forces are those of the indenter on the rubber.
struct PadStep {
  double indentation = 0;                               ///< mm
  std::array<double, 2> tangential{};                   ///< mm along x, y since first touch
  double twist = 0;                                     ///< degrees since first touch
  double P = 0;                                         ///< N
  std::array<double, 2> Q{};                            ///< N along x, y: > 0 drags the rubber to +x, +y
  double M = 0;                                         ///< N mm about the indenter's axis
  double slip_index = 0;                                ///< S = 1 / lambda, the margin of Q and M; NaN where mu P = 0
  double force_ratio = 0;                               ///< |Q| / (mu P); NaN where mu P = 0
  double stick_fraction = 0;                            ///< cells that stick over those that touch
  double slip_distance = 0;                             ///< mm: largest slide of the indenter over the rubber
  std::vector<NodeStatus> status;                       ///< [cells]
  std::vector<double> normal_force;                     ///< [cells] N, >= 0 presses
  std::vector<std::array<double, 2>> tangential_force;  ///< [cells] N along x, y
  std::vector<double> sigma_z, tau_x, tau_y;            ///< [tactels along y][along x] MPa; sigma_z < 0 is compression
  std::vector<std::array<double, 3>> markers;           ///< [markers] mm: displacements along x, y, z of the scene's
  std::vector<std::array<double, 2>> pixels;            ///< [markers] where the scene's camera sees them
  bool converged = false;
  int iterations = 0;  ///< sweeps
  PadResidual residual;
};

/// Errors to expect of an answer: 95 % of scenes stay below them.
struct PadError {
  double S = 0;
  double largest = 0;                ///< of S: almost all scenes stay below it
  double strain = 0;                 ///< the part of P and sigma that large strain adds, which the model leaves out
  std::string scenes;                ///< "this scene"; "smooth": the kind of scene, where this one was not solved twice
  std::vector<std::string> outside;  ///< what lies outside the scenes that were measured
  double P = 0, Q = 0, M = 0;        ///< over the largest P, and the larger of Q and M over half the contact's size
  double sigma = 0, tau = 0;         ///< of sigma_z, and of tau_x and tau_y, at any tactel over the largest
  std::string from{};                ///< the second solution of this scene, "24 x 24 cells"; empty: by the kind
};

/// The answer to a scene: one PadStep for each load increment, those of the pressing first.
struct PadPath {
  std::vector<PadStep> steps;
  std::vector<double> cell_x, cell_y;      ///< [cells] mm: their middles on the pad
  std::array<double, 2> cell_width{};      ///< mm, along x and y of the turned shape
  std::vector<double> tactel_x, tactel_y;  ///< [tactels along x], [tactels along y] mm
  int axes = 3;                            ///< of a tactel
  bool fell_back = false;                  ///< the exact fallback answered
  std::string rung, model;                 ///< "pad-12", "12 x 12 cells of 0.21 x 0.21 mm"
  std::string solver, precision, device;
  std::optional<PadError> error;  ///< none where nothing is touched
  std::vector<std::string> warnings;
  Outcome outcome{};
};

/// Solves one contact. Options as of a line, but `rung` "pad-8" to "pad-24" or "reference", `solver` "batched" or
/// "twin" (fp64 without a device). Every answer states its error. Throws InputError, also for a
/// contact nearer than its thickness to an edge of a pad whose sides are held, and HardwareError.
TACTEL_API PadPath solve(const PadScene& scene, const SolveOptions& options = {});

/// As those of a line; the VTK file has the cells with their tractions, or, where its name ends in .vts, displacement
/// and stress in the rubber of a pad with held sides.
TACTEL_API std::string html(const PadPath& path, std::optional<std::size_t> step = {});
TACTEL_API void to_html(const PadPath& path, const std::string& file, std::optional<std::size_t> step = {});
TACTEL_API std::string json(const PadPath& path);
TACTEL_API Convergence converge(const PadPath& path, std::optional<std::size_t> step = {});
TACTEL_API void to_vtu(const PadPath& path, const std::string& file, std::optional<std::size_t> step = {});

/// Answers of many scenes as arrays, the last index fastest; `steps` is that of the longest path. Entries beyond a
/// scene's own steps are NaN, and so are S and the force ratio where mu P = 0.
struct PadPaths {
  std::size_t scenes = 0, steps = 0;
  std::array<std::size_t, 2> tactels{};         ///< along x and y, of all scenes
  int axes = 3;                                 ///< of a tactel, of all scenes
  std::vector<std::uint32_t> steps_made;        ///< [scenes]
  std::vector<double> slip_index, force_ratio;  ///< [scenes, steps]
  std::vector<double> P, M;                     ///< [scenes, steps] N, N mm, of the indenter on the rubber
  std::vector<double> Q;                        ///< [scenes, steps, 2] N along x, y
  std::vector<double> indentation, twist;       ///< [scenes, steps] mm, degrees
  std::vector<double> tangential;               ///< [scenes, steps, 2] mm along x, y
  std::vector<double> stick_fraction;           ///< [scenes, steps]
  std::vector<double> slip_distance;            ///< [scenes, steps] mm
  std::vector<double> sigma_z, tau_x, tau_y;    ///< [scenes, steps, tactels along y, tactels along x] MPa
  std::vector<std::uint8_t> converged;          ///< [scenes, steps] 1: within its tolerance
  std::vector<std::uint8_t> fell_back;          ///< [scenes] 1: the exact fallback answered
  std::string rung, precision, device;
  std::vector<std::string> warnings;  ///< of numbers that look as if they had another unit
};

/// Solves scenes in batches, without a rung on "pad-12", in fp32 unless `options.precision` says otherwise. The pads
/// of all scenes have the same tactels. An accuracy is judged on at most 64 of the scenes. Throws InputError, naming
/// the scene by its index, also for a contact nearer than its thickness to an edge of a pad whose sides are held,
/// HardwareError, and Cancelled where progress (scenes) says so. With free sides contacts take the device, too, some
/// ten times longer each.
TACTEL_API PadPaths solve_many(std::span<const PadScene> scenes, const SolveOptions& options = {},
                               const ProgressFunction& progress = {});

}  // namespace tactel
