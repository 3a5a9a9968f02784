// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/shape_functions.h"

#include <cmath>

namespace tactel::fem {
namespace {

ShapeFunctions bilinear(double xi, double eta) {
  ShapeFunctions f{ShapeFunctions::Values(4), ShapeFunctions::Derivatives(2, 4)};
  const Eigen::Matrix2Xd node = node_coordinates(4);
  for (int i = 0; i < 4; ++i) {
    const double a = 1 + node(0, i) * xi, b = 1 + node(1, i) * eta;
    f.value[i] = a * b / 4;
    f.derivative.col(i) << node(0, i) * b / 4, node(1, i) * a / 4;
  }
  return f;
}

/// Corner: (1 + xi_i xi)(1 + eta_i eta)(xi_i xi + eta_i eta - 1)/4; middle of a side: (1 - xi^2)(1 + eta_i eta)/2 and
/// its like.
ShapeFunctions serendipity(double xi, double eta) {
  ShapeFunctions f{ShapeFunctions::Values(8), ShapeFunctions::Derivatives(2, 8)};
  const Eigen::Matrix2Xd node = node_coordinates(8);
  for (int i = 0; i < 8; ++i) {
    const double p = node(0, i), q = node(1, i);
    const double a = 1 + p * xi, b = 1 + q * eta, c = p * xi + q * eta - 1;
    if (i < 4) {
      f.value[i] = a * b * c / 4;
      f.derivative.col(i) << p * b * (c + a) / 4, q * a * (c + b) / 4;
    } else if (p == 0) {
      f.value[i] = (1 - xi * xi) * b / 2;
      f.derivative.col(i) << -xi * b, q * (1 - xi * xi) / 2;
    } else {
      f.value[i] = (1 - eta * eta) * a / 2;
      f.derivative.col(i) << p * (1 - eta * eta) / 2, -eta * a;
    }
  }
  return f;
}

}  // namespace

ShapeFunctions shape_functions(int nodes, double xi, double eta) {
  return nodes == 8 ? serendipity(xi, eta) : bilinear(xi, eta);
}

Eigen::RowVectorXd edge_functions(int nodes, double s) {
  Eigen::RowVectorXd value(nodes);
  if (nodes == 3)
    value << s * (s - 1) / 2, (1 - s) * (1 + s), s * (s + 1) / 2;
  else
    value << (1 - s) / 2, (1 + s) / 2;
  return value;
}

Eigen::Matrix2Xd node_coordinates(int nodes) {
  Eigen::Matrix2Xd coordinates(2, 8);
  coordinates << -1, 1, 1, -1, 0, 1, 0, -1,  //
      -1, -1, 1, 1, -1, 0, 1, 0;
  return coordinates.leftCols(nodes);
}

std::vector<GaussPoint> gauss_points(int per_direction) {
  const bool three = per_direction == 3;
  const std::vector<double> place =
      three ? std::vector{-std::sqrt(0.6), 0.0, std::sqrt(0.6)} : std::vector{-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)};
  const std::vector<double> weight = three ? std::vector{5.0 / 9, 8.0 / 9, 5.0 / 9} : std::vector{1.0, 1.0};
  std::vector<GaussPoint> points;
  for (std::size_t j = 0; j < place.size(); ++j)
    for (std::size_t i = 0; i < place.size(); ++i) points.push_back({place[i], place[j], weight[i] * weight[j]});
  return points;
}

}  // namespace tactel::fem
