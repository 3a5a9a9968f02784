// SPDX-License-Identifier: Apache-2.0

// A second witness for C and T of q4 and bbar: rectangles in closed form, assembled and solved in 80-bit arithmetic.
// It shares nothing with fem/ but the Sensor and Eigen's containers, and tells how exact the double precision result
// is.
#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <cstdio>

#include "fem/mesh/condensation.h"
#include "sensors.h"

namespace tactel::fem::extended_precision_test {

using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Sparse = Eigen::SparseMatrix<Real>;

/// Plane strain rectangle a x b, corners counter-clockwise from the lower left, as in any textbook; for bbar less
/// kappa times the square of what the dilatation departs from its mean: eta/(2a), xi/(2b) times the hourglass.
Matrix rectangle(bool mean_dilatation, Real a, Real b, Real shear, Real bulk) {
  const Real c = bulk + 4 * shear / 3, lambda = bulk - 2 * shear / 3;
  const int px[] = {-1, 1, 1, -1}, py[] = {-1, -1, 1, 1};
  Matrix k(8, 8);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      // Integrals of dN_i/dx dN_j/dx, of dN_i/dy dN_j/dy and of dN_i/dx dN_j/dy.
      const Real xx = px[i] * px[j] * (b / a) * (1 + py[i] * py[j] / Real(3)) / 4;
      const Real yy = py[i] * py[j] * (a / b) * (1 + px[i] * px[j] / Real(3)) / 4;
      const Real xy = px[i] * py[j] / Real(4), yx = py[i] * px[j] / Real(4);
      const Real hourglass = mean_dilatation ? bulk * px[i] * py[i] * px[j] * py[j] / 12 : 0;
      k(2 * i, 2 * j) = c * xx + shear * yy - hourglass * b / a;
      k(2 * i + 1, 2 * j + 1) = c * yy + shear * xx - hourglass * a / b;
      k(2 * i, 2 * j + 1) = lambda * xy + shear * yx;
      k(2 * i + 1, 2 * j) = lambda * yx + shear * xy;
    }
  return k;
}

/// Row heights from the base, [rows - 1] mm.
std::vector<Real> heights(const Sensor& s) {
  std::vector<Real> height;
  Real sum = 0;
  for (int j = 0; j + 1 < s.rows; ++j) {
    height.push_back(std::pow(Real(s.grading), Real(s.rows - 2 - j) / (s.rows - 2)));
    sum += height.back();
  }
  for (Real& h : height) h *= s.thickness / sum;
  return height;
}

struct Exact {
  Matrix compliance, base_force;
};

Exact solve(const Sensor& s) {
  const Real nu = s.poisson, shear = 1 / (2 * (1 + nu)), bulk = 1 / (3 * (1 - 2 * nu));
  std::vector<Eigen::Triplet<Real>> entries;
  const std::vector<Real> height = heights(s);
  for (int j = 0; j + 1 < s.rows; ++j) {
    const Matrix k = rectangle(s.element == Element::bbar, Real(s.length) / (s.columns - 1),
                               height[static_cast<std::size_t>(j)], shear, bulk);
    for (int i = 0; i + 1 < s.columns; ++i) {
      const int low = j * s.columns + i, node[] = {low, low + 1, low + s.columns + 1, low + s.columns};
      for (int p = 0; p < 8; ++p)
        for (int q = 0; q < 8; ++q) entries.emplace_back(2 * node[p / 2] + p % 2, 2 * node[q / 2] + q % 2, k(p, q));
    }
  }
  const int row = 2 * s.columns, all = row * s.rows;
  Sparse whole(all, all);
  whole.setFromTriplets(entries.begin(), entries.end());
  const Sparse free = whole.bottomRightCorner(all - row, all - row);
  Matrix load = Matrix::Zero(all - row, row);
  load.bottomRows(row).setIdentity();
  const Matrix u = Eigen::SimplicialLLT<Sparse>(free).solve(load);
  const Sparse to_base = whole.topRightCorner(row, all - row);
  return {u.bottomRows(row), -(to_base * u)};
}

class ExtendedPrecision : public testing::TestWithParam<Sensor> {};

TEST_P(ExtendedPrecision, AgreesWithTheCondensation) {
  const Condensation c = condense(GetParam());
  const Exact exact = solve(GetParam());
  const auto off = [](const Eigen::MatrixXd& ours, const Matrix& theirs) {
    return static_cast<double>((ours.cast<Real>() - theirs).cwiseAbs().maxCoeff() / theirs.cwiseAbs().maxCoeff());
  };
  const double of_c = off(c.compliance, exact.compliance), of_t = off(c.base_force, exact.base_force);
  std::printf("%-28s C off by %.1e, T by %.1e of the largest entry\n", describe(GetParam()).c_str(), of_c, of_t);
  // Rounding of the assembled volumetric stiffness: 1e-16 times about 1/(1/2 - nu) and some tens of terms.
  const double rounding = 5e-14 / (0.5 - GetParam().poisson);
  EXPECT_LT(of_c, rounding);
  EXPECT_LT(of_t, rounding);
}

std::vector<Sensor> sensors() {
  std::vector<Sensor> all;
  for (Element element : {Element::q4, Element::bbar})
    for (double nu : {0.0, 0.3, 0.45, 0.49, 0.4999}) {
      all.push_back(mesh_b(element, nu));
      if (nu >= 0.45) all.push_back(mesh_a(element, nu));
    }
  Sensor odd = mesh_b();
  odd.length = 7;
  odd.thickness = 3;
  odd.grading = 0.5;
  odd.columns = 14;
  odd.rows = 6;
  all.push_back(odd);
  return all;
}
INSTANTIATE_TEST_SUITE_P(, ExtendedPrecision, testing::ValuesIn(sensors()),
                         [](const auto& info) { return describe(info.param); });

}  // namespace tactel::fem::extended_precision_test
