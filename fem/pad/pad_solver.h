// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/pad/pad_contact.h"
#include "fem/pad/pad_layer.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// The state at the end of an asked increment, in the frame of the pad. Forces are those of the indenter on the rubber.
struct PadStep {
  double indentation = 0;             ///< mm
  double x = 0, y = 0, twist = 0;     ///< mm, rad: the indenter since first touch
  double P = 0;                       ///< N, >= 0
  Eigen::Vector2d Q = {0, 0};         ///< N, > 0 drags the rubber to +x, +y
  double M = 0;                       ///< N mm about the indenter's axis
  double mu = 0;                      ///< of the scene; with a map its mean, weighed by the pressures
  std::optional<double> slip_index;   ///< S = 1 / lambda (slip_margin.h); none where mu P = 0
  std::optional<double> force_ratio;  ///< |Q| / (mu P)
  double stick_fraction = 0;          ///< cells that stick over those that touch; 0 where none touches
  double slip_distance = 0;           ///< mm: how far the indenter has slid over the rubber at most
  double slid = 0;                    ///< mm: rms slide of the cells over all increments in which none sticks
  double slip_path = 0;               ///< mm: the same over all increments
  double area = 0;                    ///< mm^2 of the cells that touch
  int across = 0;                     ///< cells over which it extends, along the shorter side
  PadBox reach{nowhere, nowhere};     ///< around these, along the pad from the indenter's axis
  std::vector<GapStatus> status;      ///< [cells]
  Eigen::VectorXd normal_force;       ///< [cells] N
  Eigen::MatrixX2d tangential_force;  ///< [cells] N
  Eigen::MatrixX3d straining;         ///< [cells] N, as both: what would strain elastic rubber as far; of rubber that
                                      ///< creeps
  Eigen::MatrixX3d stress;            ///< [tactels, x fastest] MPa: sigma_z, tau_x, tau_y of the rubber on the base
  Eigen::MatrixX3d markers;           ///< [markers] mm: displacements (see_markers)
  Eigen::MatrixX2d pixels;            ///< [markers] where a camera sees them
  bool converged = false;             ///< and so are all steps before it
  int iterations = 0;                 ///< sweeps since the last asked step
  PadResidual residual;
};

struct PadSolution {
  PadCells cells;           ///< in the indenter's own frame
  Eigen::MatrixX2d places;  ///< [cells] mm: middles of the cells on the pad
  std::vector<PadStep> steps;
  std::array<bool, 4> outside{};  ///< sides -x, +x, -y, +y of the own frame beyond which the surface is penetrated
  bool fell_back = false;         ///< the pad kernel did not solve it, the twin did
};

/// One increment, in the frame of the pad.
struct PadIncrement {
  PadTarget target;
  bool asked = true;  ///< the load has it, and the answer a step for it
  double dt = 0;      ///< s that it takes, of rubber that creeps
};

/// Returns the heights at cells and one ring around them (cell_heights), +infinity also where a pad with free sides has
/// ended.
Eigen::MatrixXd heights_on_pad(const PadCells& cells, const PadScene& scene);

/// Returns mu at the cells.
Eigen::VectorXd friction_on_cells(const PadCells& cells, const PadScene& scene);
/// Returns the mu that would bear as much under pressures n: that of the scene, with a map the mean of those of cells.
double mean_friction(const PadScene& scene, const Eigen::VectorXd& mu, const Eigen::VectorXd& n);

/// Returns what each shared cell gives way beside the rubber (share_compliance), [cells] mm for E = 1; 0 of others.
Eigen::VectorXd shared_compliances(const PadCells& cells, const PadScene& scene);

/// Returns about how far a drag goes before all of the contact slides, mm, at a depth or force. On a half-space that is
/// mu P over the tangential stiffness 8 G a / (2 - nu) of a flat or (as 3/2 mu P) curved contact of radius a, and with
/// P by the depth d for both
///
///     mu d (2 - nu) / (2 (1 - nu))
///
/// (R. D. Mindlin, J. Appl. Mech. 16, 1949, 259-268). A layer bears more at a depth, and is stiffer by G area / H.
double sliding_limit(const PadScene& scene, double normal, const PadCells& cells);

/// Returns the increments of a scene's load on cells. Where the slip of a cell turns within an increment, its traction
/// is wrong by that turn. So a drag takes limit_increments for each sliding limit of its length (a twist moves by
/// the half size of the cells), up to four times as many where it turns off the last one. Once all slides steadily more
/// would change nothing: it never takes more than for two limits.
std::vector<PadIncrement> pad_increments(const PadScene& scene, const PadOptions& options, const PadCells& cells);

/// Returns the middles of the tactels on the pad, [tactels, x fastest] mm.
Eigen::MatrixX2d tactel_places(const PadSensor& sensor);

/// Points at which the base stress is computed.
struct TactelPoints {
  explicit TactelPoints(const PadSensor& sensor);
  /// Points along the side of a tactel, some for each H; 1: it is a point.
  static int along(const PadSensor& sensor);

  Eigen::MatrixX2d places;      ///< [tactels][points of a tactel] mm
  std::vector<double> weights;  ///< [points of a tactel]; their sum is 1
};

/// Returns how often the layer's integrals are taken for base_stress_of_cells: some 20 ns each.
double base_stress_work(const PadScene& scene, const PadCells& cells);

/// Returns by rows [3 tactels] (sigma_z, tau_x, tau_y of each) the base stress, in the frame of the pad, of unit
/// pressures and tractions in the indenter's own frame: columns [3 cells], n, t_x, t_y of each.
Eigen::MatrixXd base_stress_of_cells(const PadLayer& layer, const PadScene& scene, const PadCells& cells);
/// The same on a pad with free sides, from uniform tractions on the cells.
Eigen::MatrixXd base_stress_of_cells(const PadLayer& layer, const PadScene& scene, const PadCells& cells,
                                     const PadSides& sides);

/// Returns the cells grown by one and a half cells on the sides given.
PadCells grown(const PadCells& cells, const std::array<bool, 4>& sides, const PadScene& scene, bool ladder);

/// Contact on a pad, fp64, one scene at a time: the twin of the pad kernel. It shares the algorithm with the kernel,
/// but no code. A pad with free sides is solved on a table of its own. Keeps a reference to the layer,
/// which must be that of the scenes (pad_layer).
class PadSolver {
 public:
  explicit PadSolver(const PadLayer& layer, const PadOptions& options = {});

  /// Solves a scene. Where the surface is penetrated beyond the grid, that grows, and the scene is solved again. Coarse
  /// steps of the pressing are solved alone (pad_presses.h).
  PadSolution solve(const PadScene& scene) const;

  /// The same on given cells, which do not grow.
  PadSolution solve_on(const PadCells& cells, const PadScene& scene) const;

  const PadOptions& options() const { return options_; }

 private:
  PadSolution solve_on_grown(const PadScene& scene) const;

  const PadLayer& layer_;
  PadOptions options_;
};

}  // namespace tactel::fem
