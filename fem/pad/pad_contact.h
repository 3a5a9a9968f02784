// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "fem/gap/accuracy.h"
#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_table.h"

namespace tactel::fem {

/// Options of contacts on pads, for the kernel and its twin.
struct PadOptions {
  int cells = 12;               ///< along a side; the kernel has 8, 12, 16 and 24, each its own program
  double tolerance = 1e-3;      ///< largest change of a traction in the last sweep over the largest pressure; of given
                                ///< forces, which a tenth of it serves in the sweeps
  double accept = 0;            ///< largest residual of a solved step, to which sweeps go on; 0: as the kernel in fp32
  int pressing_increments = 0;  ///< least number of increments to each pressing target; 0: cells / 3, at least 2
  int drag_increments = 1;      ///< of each drag, at least
  int limit_increments = -1;    ///< of a drag as long as sliding_limit(), at least; -1: cells / 3
  int parts = 1;                ///< of each of these increments
  bool ladder = true;           ///< cell sizes that scenes share (pad_cells)
  int most_sweeps = 2000;       ///< an increment that needs more is not converged; those after it get 300
  int most_growths = 4;         ///< times that the grid may grow
  // Of the twin alone.
  SideBricks side_bricks = SideBricks::usual;    ///< of free sides
  bool whole_path = true;                        ///< false: steps after one that is not converged are left out
  std::function<void()> between_sweeps = [] {};  ///< and while tables are made (sides_at); may throw, which ends it
  // Of the kernel alone.
  bool any_poisson = false;  ///< scenes with a Poisson's ratio each: tables by polynomials in it, right to 1e-7
  int vectors = 0;           ///< of scenes in a work-item, 1 to 3; 0: by the size of the batch

  double accepted() const { return accept > 0 ? accept : std::min(slow_on_patch * tolerance, largest_accept<float>); }
  int increments() const { return pressing_increments > 0 ? pressing_increments : std::max(2, cells / 3); }
  double to_limit() const { return limit_increments < 0 ? cells / 3.0 : limit_increments; }
};

/// Sweeps after which steps are halved: where friction is high they may go round in circles.
inline constexpr int damped_after = 300;

/// Residual of the contact laws, from the final tractions alone; all members are relative.
struct PadResidual {
  double penetration = 0;      ///< largest penetration of a cell, also of the ring around the grid, over the depth
  double complementarity = 0;  ///< largest |gap| of a cell with n > 0, over the depth
  double cone = 0;             ///< largest |t| - mu n over the largest n
  double drift = 0;            ///< largest slip of a sticking cell over the motion of the increment, at least 0.1 depth
  double angle = 0;            ///< largest (1 - cos) slip, by the angle between traction and slip; as drift

  double largest() const;
};

/// A rigid motion of the indenter in its own frame: x, y (mm), twist (rad) about its axis.
using PadMotion = Eigen::Vector3d;

/// The cells under one indenter, and where it is. Tractions are over E: n >= 0 presses, t drags the rubber along. With
/// the influence C at E = 1 and offsets from source to place,
///
///     u_z = -sum (zz n + xz t_x + yz t_y)    u_x = sum (xx t_x + xy t_y - xz n)    u_y = sum (xy t_x + yy t_y - yz n)
///     gap = h - d - u_z >= 0,  n >= 0,  n gap = 0;    |t| <= mu n,  t along the slip of the indenter over the rubber
///
/// Projected Gauss-Seidel over the cells, relaxed by w = 0.85 (M. Jean, Comput. Methods Appl. Mech. Eng. 177, 1999,
/// 235-257, with the disc of friction): with g where a cell would be if it stuck, and C_zz, C_tt of a cell on itself,
///
///     n <- max(0, n + w (u_z - (h - d)) / C_zz)
///     t <- t + w (g - u_t) / C_tt, shortened to mu n where it is longer
class PadContact {
 public:
  /// `height` as cell_heights gives it.
  PadContact(const PadInfluence& influence, const PadCells& cells, Eigen::MatrixXd height, double mu,
             const PadOptions& options);
  /// The same on a pad with free sides; C_zz and C_tt are then each cell's own.
  PadContact(const PadTable& table, const PadCells& cells, Eigen::MatrixXd height, double mu,
             const PadOptions& options);

  /// Other heights from now on, and the compliance that each cell has of its own, [cells], over that on itself; empty:
  /// 0.
  void set_heights(Eigen::MatrixXd height, Eigen::VectorXd softness);
  /// Friction of each cell from now on, [cells].
  void set_friction(Eigen::VectorXd mu) { mu_ = std::move(mu); }
  const Eigen::VectorXd& friction() const { return mu_; }  ///< [cells]
  /// Where the axis of the indenter lies from the middle of the grid, about which it twists, mm.
  void set_axis(double x, double y) { cells_.x_middle = -x, cells_.y_middle = -y; }

  double depth = 0;                      ///< mm, set by the caller
  PadMotion motion = PadMotion::Zero();  ///< since first touch, set by the caller

  /// Before and after an increment in which the rubber creeps: it counts as lower by `crept`, [cells] mm x, y, z, and
  /// as so many times softer, so that tractions are so many times larger.
  void creep(const Eigen::MatrixX3d& crept, double softer);
  const Eigen::MatrixX3d& displacements() const { return u_; }  ///< [cells] mm, by the last fresh sums

  const Eigen::VectorXd& n() const { return n_; }   ///< [cells]
  const Eigen::MatrixX2d& t() const { return t_; }  ///< [cells]
  double pressing() const { return n_.sum(); }
  bool sticks(Eigen::Index i) const { return n_[i] > 0 && t_.row(i).norm() < (1 - 1e-12) * mu_[i] * n_[i]; }

  /// Starts an increment: guesses that the tractions change `ratio` times as much as last time.
  void extrapolate(double ratio);

  /// Sweeps over the window, the cells that press or would be penetrated, until no traction changes by more than the
  /// tolerance; then over more cells where fresh sums find more. Returns false where `most_sweeps` do not suffice.
  bool solve(int most_sweeps, int& sweeps);

  /// After solve(): returns true where the residual of the cells is not accepted yet, and solve() is to go on, with a
  /// quarter of the tolerance. Slow modes, of nearly incompressible rubber under wide contacts, change little in a
  /// sweep long before they have settled.
  bool refine();

  /// State of the laws from the tractions alone. `outside` takes the sides -x, +x, -y, +y beyond which the surface is
  /// penetrated by more than the accepted residual times the depth.
  PadResidual residual(std::array<bool, 4>& outside) const;

  /// Returns the rms slide in this increment of the cells that touch, mm, after solve().
  double slide() const;
  /// Returns their mean slide x, y, and its turn times their rms distance from their middle, mm. Those that stick have
  /// none.
  Eigen::Vector3d mean_slide() const;
  /// Adds slide() to slip_path(), and to slid() where no cell sticks.
  void add_slide();

  /// Ends an increment. A sticking cell counts as having followed the indenter, so that what the tolerance left is made
  /// good by the next increment; another one has slipped to where it is.
  void remember();

  /// Returns how far the indenter has slid over the rubber since first touch at most, mm.
  double slip_distance() const;
  /// Returns how far the contact has slid as a whole: the sum over the increments without a sticking cell of the rms
  /// slide of the cells that touch, mm.
  double slid() const { return slid_; }
  /// Returns the sum over all increments of the rms slide of the cells that touch, mm.
  double slip_path() const { return slip_path_; }

 private:
  PadContact(const PadInfluence* influence, const PadTable* table, const PadCells& cells, Eigen::MatrixXd height,
             double mu, const PadOptions& options);
  Eigen::Vector3d displacement(int ix, int iy) const;
  Eigen::Vector3d displacement_of_cell(int i) const;
  double softness(int i) const { return softness_.size() > 0 ? softness_[i] : 0; }
  Eigen::Vector3d displacement_by_table(int ix, int iy) const;
  Eigen::Vector2d path(Eigen::Index i, const PadMotion& from) const;
  Eigen::RowVector2d slip(Eigen::Index i) const;
  double sweep(double w);
  void activate(Eigen::Index i);
  bool widen();
  PadResidual residual_of_cells() const;

  const PadInfluence* influence_;  ///< nullptr: table_ instead
  const PadTable* table_;
  PadCells cells_;
  Eigen::MatrixXd height_;
  Eigen::VectorXd softness_;
  Eigen::VectorXd mu_;
  PadOptions options_;
  double tolerance_;  ///< of this increment
  Eigen::VectorXd n_, n_last_;
  Eigen::MatrixX2d t_, t_last_;
  Eigen::MatrixX2d stick_;  ///< mm: where a cell was at the last increment; it sticks from there
  Eigen::MatrixX2d crept_;  ///< mm: where cells lie besides, in an increment
  Eigen::MatrixX3d u_;      ///< mm: displacements by fresh sums
  PadMotion motion_last_ = PadMotion::Zero();
  double slid_ = 0, slip_path_ = 0;          ///< mm
  std::vector<char> active_;                 ///< [cells] in the window
  std::vector<std::array<int, 2>> columns_;  ///< [n] first and one after last active cell of each column
};

}  // namespace tactel::fem
