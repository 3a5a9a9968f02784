// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/brick.h"

#include <array>
#include <cmath>
#include <numbers>

namespace tactel::fem {
namespace {

using Strains = Eigen::Matrix<double, 6, 24>;  ///< xx, yy, zz, yz, zx, xy by the corners' displacements
constexpr std::array<double, 2> ends{-1, 1};

/// At a point of the cube [-1, 1]^3.
Strains strains(const Eigen::Array3d& point, const Eigen::Array3d& sides) {
  Strains b = Strains::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3d at(ends[corner / 4], ends[corner / 2 % 2], ends[corner % 2]), shape = 1 + at * point;
    for (int axis = 0; axis < 3; ++axis) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      const double slope = at[axis] / sides[axis] / 4 * shape[next] * shape[last];
      b(axis, 3 * corner + axis) = slope;
      b(3 + next, 3 * corner + last) += slope;  // each shear strain joins the two other axes
      b(3 + last, 3 * corner + next) += slope;
    }
  }
  return b;
}

}  // namespace

BrickMatrix brick_stiffness(double hx, double hy, double hz, double poisson) {
  const double shear = 1 / (2 * (1 + poisson)), bulk = 1 / (3 * (1 - 2 * poisson)), volume = hx * hy * hz;
  Eigen::Vector<double, 6> twice;  // of the shear modulus: engineering shear strains have half
  twice << 2, 2, 2, 1, 1, 1;
  BrickMatrix k = BrickMatrix::Zero();
  Eigen::RowVector<double, 24> dilatation = Eigen::RowVector<double, 24>::Zero();
  for (int point = 0; point < 8; ++point) {
    const Eigen::Array3d at =
        Eigen::Array3d(ends[point / 4], ends[point / 2 % 2], ends[point % 2]) / std::numbers::sqrt3;
    Strains b = strains(at, {hx, hy, hz});
    const Eigen::RowVector<double, 24> volumetric = b.topRows<3>().colwise().sum();
    dilatation += volumetric / 8;
    b.topRows<3>().rowwise() -= volumetric / 3;
    k += shear * volume / 8 * b.transpose() * twice.asDiagonal() * b;
  }
  return k + bulk * volume * dilatation.transpose() * dilatation;
}

std::vector<double> brick_levels(double thickness, int layers, double growth) {
  std::vector<double> levels{0};
  for (int k = 0; k < layers; ++k) levels.push_back(levels.back() + std::pow(growth, -k));
  const double whole = levels.back();
  for (double& level : levels) level *= thickness / whole;
  return levels;
}

}  // namespace tactel::fem
