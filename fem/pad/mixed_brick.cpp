// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/mixed_brick.h"

#include "fem/layer/legendre_points.h"

namespace tactel::fem {
namespace {

using MixedStrains = Eigen::Matrix<double, 6, MixedBrick::unknowns>;  ///< xx, yy, zz, yz, zx, xy by displacements

/// At a point of the cube [-1, 1]^3.
MixedStrains mixed_strains(const Eigen::Array3d& point, const Eigen::Array3d& sides) {
  MixedStrains b = MixedStrains::Zero();
  Eigen::Array33d value, slope;  // [axis][of three]
  for (int axis = 0; axis < 3; ++axis)
    value.row(axis) = quadratics(point[axis]), slope.row(axis) = 2 / sides[axis] * quadratic_slopes(point[axis]);
  for (int node = 0; node < 27; ++node) {
    const Eigen::Array3i at(node / 9, node / 3 % 3, node % 3);
    for (int axis = 0; axis < 3; ++axis) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      const double along = slope(axis, at[axis]) * value(next, at[next]) * value(last, at[last]);
      b(axis, 3 * node + axis) = along;
      b(3 + next, 3 * node + last) += along;  // each shear strain joins the two other axes
      b(3 + last, 3 * node + next) += along;
    }
  }
  return b;
}

}  // namespace

Eigen::Array3d quadratics(double at) { return {at * (at - 1) / 2, 1 - at * at, at * (at + 1) / 2}; }
Eigen::Array3d quadratic_slopes(double at) { return {at - 0.5, -2 * at, at + 0.5}; }

MixedBrick::MixedBrick(double hx, double hy, double hz, double poisson)
    : sides_(hx, hy, hz), shear_(1 / (2 * (1 + poisson))), stiffness_(Eigen::MatrixXd::Zero(unknowns, unknowns)) {
  const double bulk = 1 / (3 * (1 - 2 * poisson)), volume = sides_.prod();
  Eigen::Vector<double, 6> twice;  // of the shear modulus: engineering shear strains have half
  twice << 2, 2, 2, 1, 1, 1;
  Eigen::Matrix<double, 4, unknowns> dilatation = Eigen::Matrix<double, 4, unknowns>::Zero();
  const std::vector<LegendrePoint> points = legendre_points(3);
  for (const LegendrePoint& p : points)
    for (const LegendrePoint& q : points)
      for (const LegendrePoint& r : points) {
        const double weight = p.weight * q.weight * r.weight / 8 * volume;
        MixedStrains b = mixed_strains({p.x, q.x, r.x}, sides_);
        const Eigen::RowVector<double, unknowns> volumetric = b.topRows<3>().colwise().sum();
        dilatation += weight * Eigen::Vector4d(1, p.x, q.x, r.x) * volumetric;
        b.topRows<3>().rowwise() -= volumetric / 3;
        stiffness_.noalias() += shear_ * weight * b.transpose() * twice.asDiagonal() * b;
      }
  // 1, x, y and z are orthogonal over the cube.
  pressure_ = bulk / volume * Eigen::Vector4d(1, 3, 3, 3).asDiagonal() * dilatation;
  stiffness_.noalias() += dilatation.transpose() * pressure_;
}

Eigen::MatrixXd MixedBrick::face_stress(double x, double y) const {
  const MixedStrains b = mixed_strains({x, y, -1}, sides_);
  Eigen::MatrixXd stress(3, unknowns);
  stress.row(0) = shear_ * b.row(4);
  stress.row(1) = shear_ * b.row(3);
  stress.row(2) =
      Eigen::RowVector4d(1, x, y, -1) * pressure_ + 2 * shear_ * (b.row(2) - b.topRows<3>().colwise().sum() / 3);
  return stress;
}

}  // namespace tactel::fem
