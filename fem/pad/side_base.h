// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <filesystem>
#include <functional>

#include "fem/mesh/condensation.h"
#include "fem/numbers/cache_directory.h"
#include "fem/pad/base_block.h"
#include "fem/pad/side_grid.h"

namespace tactel::fem {

/// How the bricks below a base's stress are graded; lengths over H. The finest, at the sides and the base, are so much
/// of the least of H and half a side.
struct BaseGrading {
  double finest = 0.055, growth = 2.3;
  double widest = 0.5, highest = 0.55;
  static constexpr double far = 3, far_width = 1;  ///< so far from a side bricks may be so wide
};

/// What the free sides of a pad add to the stress on its base, as SideKernel to the surface: the stress of a block of
/// bricks less that of the endless layer by uniform tractions on the cells of a grid, which is smooth in the place of
/// the cells. It dies out as exp(-pi / 2 of the distance from a side), and is taken away from 2 to 4.
/// Lengths over H, E = 1. Some tenths of a second; a file of the cache holds it.
class SideBase {
 public:
  /// 0 <= poisson <= 1/2, above 0.49999 of that. `between` as in base_block.
  SideBase(
      const SideGrid& grid, double poisson, const BaseGrading& grading,
      const std::filesystem::path& cache_directory = default_cache_directory(),
      const std::function<void()>& between = [] {});

  /// Returns how many floating-point operations it takes to make one; 0 where a file of the cache holds it.
  static double work(const SideGrid& grid, double poisson, const BaseGrading& grading);

  const SideGrid& grid() const { return grid_; }

  /// Stress at a place from the block's middle, rows sigma_z, tau_x, tau_y, by unit forces on the cells: [3][3 cells],
  /// [i cells[1] + j].
  Eigen::MatrixXd stress(double x, double y) const;

 private:
  void make(double poisson, const BaseMesh& mesh, const std::function<void()>& between);

  SideGrid grid_;
  std::array<std::vector<double>, 2> places_;
  Eigen::MatrixXd rows_;  ///< [3 places][3 cells of the quarter x > 0, y > 0]: tau_x, tau_y, sigma_z
};

}  // namespace tactel::fem
