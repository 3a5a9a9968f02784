// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tactel::fem {

/// Cubic through four neighbouring nodes of a uniform grid (Catmull and Rom); linear beyond the ends and in
/// `linear_cells` cells at each. `rows`: [nodes, any]; `x`: [nodes] of which the first two give the spacing.
inline Eigen::RowVectorXd between_nodes(const Eigen::VectorXd& x, const Eigen::MatrixXd& rows, double at,
                                        Eigen::Index linear_cells = 1) {
  const Eigen::Index last = rows.rows() - 1;
  const double place = (at - x[0]) / (x[1] - x[0]);
  const Eigen::Index i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::floor(place)), 0, last - 1);
  const double q = place - static_cast<double>(i);
  const Eigen::RowVectorXd from = rows.row(i), to = rows.row(i + 1);
  if (q < 0 || q > 1 || i < linear_cells || i + linear_cells >= last) return from + q * (to - from);
  const Eigen::RowVectorXd slope = (to - rows.row(i - 1)) / 2, end_slope = (rows.row(i + 2) - from) / 2;
  const Eigen::RowVectorXd rise = to - from;
  return from + q * (slope + q * (3 * rise - 2 * slope - end_slope + q * (slope + end_slope - 2 * rise)));
}

}  // namespace tactel::fem
