// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>

#include "fem/mesh/condensation.h"
#include "fem/numbers/cache_directory.h"
#include "fem/pad/pad_scene.h"
#include "fem/pad/side_base.h"
#include "fem/pad/side_grid.h"

namespace tactel::fem {

// What the free sides of a pad add to the endless layer: the block of bricks less an endless layer of the same bricks,
//
//     C = C_layer + (C_block - C_endless),
//
// where singular parts and errors of the bricks cancel, so that the difference is smooth: cubics between the cells of a
// coarse grid give it at any two places. Against 96 x 96 x 10 bricks, 12 x 12 cells leave P .2 to .7 % and S .004.

/// The bricks of a side kernel.
struct SideMesh {
  std::array<int, 2> cells{12, 12};  ///< along x and y, even
  int along = 2;                     ///< bricks along a side of a cell
  int layers = 6;
  double growth = 1.15;                 ///< of the layers, from the surface down
  std::array<int, 2> period{128, 128};  ///< bricks along x and y, of the endless layer
};

/// Bricks of a block: the usual ones, more cells to judge them by, and more of all for references.
enum class SideBricks { usual, finer, finest };

/// Returns the bricks of a block, sides over H: cells of H / 2, 12 to 24 along a side, 16 or more of finer ones.
SideMesh side_mesh(const std::array<double, 2>& sides, SideBricks bricks);

/// The side part of a block of one shape and Poisson's ratio; lengths over H, E = 1. Some tenths of a second; a file of
/// the cache holds it.
class SideKernel {
 public:
  /// 0 <= poisson <= 1/2, above 0.49999 of that. `between` as in brick_block.
  SideKernel(
      const std::array<double, 2>& sides, double poisson, const SideMesh& mesh,
      const std::filesystem::path& cache_directory = default_cache_directory(),
      const std::function<void()>& between = [] {});

  /// Returns how many floating-point operations it takes to make one; 0 where a file of the cache holds it.
  static double work(const std::array<double, 2>& sides, double poisson, const SideMesh& mesh);

  const std::array<double, 2>& sides() const { return sides_; }
  const SideMesh& mesh() const { return mesh_; }

  using Shares = SideGrid::Shares;
  Shares shares(double x, double y) const { return SideGrid{sides_, mesh_.cells}.shares(x, y); }

  /// Displacement of the surface by a unit force on it, between nodes: [3 nodes][3 nodes], x, y, z of each.
  const Eigen::MatrixXd& displacement() const { return displacement_; }

  /// zz of it alone, [nodes][nodes].
  const Eigen::MatrixXd& normal_displacement() const { return normal_; }

 private:
  int nodes() const { return mesh_.cells[0] * mesh_.cells[1]; }
  int quarter() const { return nodes() / 4; }
  void make(double poisson, const std::function<void()>& between);
  void unfold();

  std::array<double, 2> sides_;
  SideMesh mesh_;
  Eigen::MatrixXd quarter_;  ///< [3 nodes][3 nodes of the quarter x > 0, y > 0]: columns of displacement_
  Eigen::MatrixXd displacement_, normal_;
};

/// Whether the sides of a pad are free in its model.
bool has_free_sides(const PadSensor& sensor);

/// What the sides of a pad mean to those who solve it.
struct SideRules {
  Sides sides = Sides::held;
  int most_cells = std::numeric_limits<int>::max();  ///< along a side: tables of free sides have 9 cells^2 numbers
  double order = 1.5;        ///< of the error in the size of cells: 1 where tractions at bonded sides are singular
  bool knows_inside = true;  ///< displacements and stresses between surface and base
};
SideRules side_rules(const PadSensor& sensor);

/// Returns the surface of a pad: its box where the sides are free, else everywhere.
PadBox rubber_of(const PadSensor& sensor);

/// Returns about how long the tables of a pad's free sides take to make, s on one core: of usual bricks, of others to
/// judge by, and of the base. Those that files of the cache hold take none, and so do held sides.
double seconds_for_sides(const PadSensor& sensor, SideBricks judge);

/// The free sides of a pad, where a contact on it lies; none of one whose sides are held. Of pads longer than
/// longest_block H the contact sees a block of that length, flush with the nearer side.
struct PadSides {
  std::shared_ptr<const SideKernel> kernel{};
  std::shared_ptr<const SideBase> base{};  ///< of the cells of a kernel of usual bricks
  double thickness = 1;                    ///< mm
  Eigen::Vector2d middle{0, 0};            ///< mm on the pad: the block's

  bool free() const { return kernel != nullptr; }
  Eigen::Vector2d in_block(const Eigen::Vector2d& place) const { return (place - middle) / thickness; }
};
inline constexpr double longest_block = 12;  ///< H

/// Returns the sides that a contact around a place on the pad, mm, has; tables of this process are kept. Those of the
/// surface and of the base are made side by side. `between` is called often, by two threads, and may throw, which ends
/// it.
PadSides sides_at(
    const PadSensor& sensor, const Eigen::Vector2d& place, SideBricks bricks,
    const std::function<void()>& between = [] {});

}  // namespace tactel::fem
