// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace tactel::fem {

/// Interpolation functions at a point (xi, eta) of the square [-1, 1] x [-1, 1]. Node order as in Mesh::cell.
struct ShapeFunctions {
  using Values = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 8>;
  using Derivatives = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 8>;
  Values value;            ///< [nodes]
  Derivatives derivative;  ///< [2, nodes]: d/dxi, d/deta
};

/// Returns bilinear (4 nodes) or serendipity functions (8 nodes: corners, then the middles of bottom, right, top,
/// left). Hughes, The Finite Element Method (1987), sections 3.2 and 3.7.
ShapeFunctions shape_functions(int nodes, double xi, double eta);

/// Returns the interpolation along an edge, -1 <= s <= 1: linear (2 nodes) or quadratic (3 nodes: left, middle,
/// right).
Eigen::RowVectorXd edge_functions(int nodes, double s);

/// Returns (xi, eta) of an element's nodes, [2, nodes].
Eigen::Matrix2Xd node_coordinates(int nodes);

struct GaussPoint {
  double xi, eta, weight;
};
/// Returns the Gauss-Legendre points of the square, `per_direction` = 2 or 3, xi running fastest.
std::vector<GaussPoint> gauss_points(int per_direction);

}  // namespace tactel::fem
