// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "fem/layer/side_difference.h"

namespace tactel::fem {

/// What one free end of a layer changes, for Poisson's ratios between nodes: the difference of side_difference.h,
/// reduced to modes that serve all of them and small matrices that belong to one. Lengths in units of h, E = 1 MPa.
/// With the distances s and s' from a left end,
///     u_a at s by f_b at s'         sum_rq u_ra(s) C_rq u_qb(s'),                   a, b = y or x, C symmetric
///     stress_a at s by f_b at s'    sum_rq stress_ra(s) K_rq force_qb(s') / h,      a = sigma_y or tau_xy.
/// At a right end x counts the other way: u_x, f_x and tau_xy change their sign. The ends of a sensor that is long
/// enough do not feel each other, and their changes add.
class EndModes {
 public:
  static constexpr int rank = 8;
  static constexpr int rows_a_thickness = 48;
  static constexpr int reach = 10;  ///< h; beyond it an end changes nothing that counts
  using Core = Eigen::Matrix<double, rank, rank>;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// `differences`: [nodes] of blocks twice as long as the reach, of one thickness.
  explicit EndModes(const std::vector<SideDifference>& differences);

  Rows displacement;              ///< [rows, 2 rank] u_y of every mode, then u_x; linear between rows, the last is 0
  Rows force;                     ///< [rows, 2 rank] by f_y, then by f_x
  Rows stress;                    ///< [rows, 2 rank] sigma_y, then tau_xy
  std::vector<Core> compliance;   ///< [nodes] C
  std::vector<Core> base_stress;  ///< [nodes] K

  /// Returns the row [2 rank] of a table at a distance from the end; before the end that at the end.
  static Eigen::RowVectorXd at(const Rows& rows, double distance);
};

}  // namespace tactel::fem
