// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>

namespace tactel::fem {

/// A parity about the planes x = 0 and y = 0: +1 where displacements are mirror images, -1 where their negatives are.
struct Parity {
  int x, y;
  /// What a component is multiplied by where it is mirrored in x, or in y.
  int in_x(int component) const { return component == 0 ? -x : x; }
  int in_y(int component) const { return component == 1 ? -y : y; }
};

/// Sign of a component where it is mirrored in x, or in y.
inline double mirrored(int component, bool in_x, bool in_y) {
  return (in_x && component == 0 ? -1 : 1) * (in_y && component == 1 ? -1 : 1);
}

/// Adds what a quarter says of the whole to `to`, [3 (i n + j) + component]: `count` places along x and y from the
/// middle outwards, which the whole has from one side to the other.
void unfold(const Eigen::MatrixXd& quarter, Parity parity, std::array<int, 2> count, Eigen::MatrixXd& to);

}  // namespace tactel::fem
