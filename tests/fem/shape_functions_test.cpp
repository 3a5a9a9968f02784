// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/shape_functions.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tactel::fem::shape_functions_test {

TEST(ShapeFunctions, OneAtTheirNodeAndZeroAtTheOthers) {
  for (int nodes : {4, 8}) {
    const Eigen::Matrix2Xd at = node_coordinates(nodes);
    for (int k = 0; k < nodes; ++k) {
      const auto value = shape_functions(nodes, at(0, k), at(1, k)).value;
      for (int i = 0; i < nodes; ++i) EXPECT_EQ(value[i], i == k ? 1 : 0) << nodes << " nodes, " << i << " at " << k;
    }
  }
  for (int nodes : {2, 3})
    for (int k = 0; k < nodes; ++k)
      EXPECT_EQ(edge_functions(nodes, -1 + 2.0 * k / (nodes - 1)), Eigen::RowVectorXd::Unit(nodes, k));
}

TEST(ShapeFunctions, DerivativesAgreeWithDifferences) {
  constexpr double h = 1e-5;
  for (int nodes : {4, 8})
    for (double xi : {-0.7, 0.2})
      for (double eta : {-0.3, 0.9}) {
        const auto f = shape_functions(nodes, xi, eta);
        const Eigen::RowVectorXd by_xi =
            (shape_functions(nodes, xi + h, eta).value - shape_functions(nodes, xi - h, eta).value) / (2 * h);
        const Eigen::RowVectorXd by_eta =
            (shape_functions(nodes, xi, eta + h).value - shape_functions(nodes, xi, eta - h).value) / (2 * h);
        // Cubic at most in each direction: the error is h^2 times a third derivative, here zero; rounding 1e-16 / h
        // remains.
        EXPECT_LT((f.derivative.row(0) - by_xi).cwiseAbs().maxCoeff(), 1e-10);
        EXPECT_LT((f.derivative.row(1) - by_eta).cwiseAbs().maxCoeff(), 1e-10);
      }
}

TEST(GaussPoints, IntegrateWhatTheyShould) {
  for (int n : {2, 3})
    for (int p = 0; p < 2 * n; ++p)
      for (int q = 0; q < 2 * n; ++q) {
        double sum = 0;
        for (const GaussPoint& g : gauss_points(n)) sum += g.weight * std::pow(g.xi, p) * std::pow(g.eta, q);
        const auto line = [](int k) { return k % 2 ? 0.0 : 2.0 / (k + 1); };
        EXPECT_NEAR(sum, line(p) * line(q), 1e-15) << "xi^" << p << " eta^" << q;  // nine terms near 1/4
      }
}

}  // namespace tactel::fem::shape_functions_test
