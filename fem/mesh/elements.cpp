// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/elements.h"

#include <vector>

#include "fem/mesh/shape_functions.h"

namespace tactel::fem {
namespace {

// Strain from displacements, [4, 2 nodes (+ 4 internal of q4i)] 1/mm: eps_x, eps_y, gamma_xy, eps_z.
using StrainOperator = Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, 16>;
using Gradients = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 8>;
constexpr int internal_modes = 2;  // of q4i, each with an x and a y amplitude

struct IntegrationPoint {
  double xi, eta;
  double volume;          ///< weight times Jacobian, mm2
  StrainOperator strain;  ///< of this point
};

/// Stress from strain, rows sigma_x, sigma_y, tau_xy, sigma_z: 2 G dev(eps) + kappa tr(eps).
Eigen::Matrix4d elasticity(const Material& m) {
  Eigen::Matrix4d d = Eigen::Matrix4d::Zero();
  for (int i : {0, 1, 3})
    for (int j : {0, 1, 3}) d(i, j) = m.bulk - 2 * m.shear / 3 + (i == j ? 2 * m.shear : 0);
  d(2, 2) = m.shear;
  return d;
}

/// Plane strain: eps_z = 0 for now; bbar changes it.
StrainOperator strain_operator(const Gradients& gradient) {
  StrainOperator b = StrainOperator::Zero(4, 2 * gradient.cols());
  for (Eigen::Index k = 0; k < gradient.cols(); ++k) {
    b(0, 2 * k) = b(2, 2 * k + 1) = gradient(0, k);
    b(1, 2 * k + 1) = b(2, 2 * k) = gradient(1, k);
  }
  return b;
}

/// [2, 2]: d(x, y)/d(xi, eta), transposed as in the chain rule: d/d(xi, eta) = jacobian * d/d(x, y).
Eigen::Matrix2d jacobian(const ElementNodes& node, double xi, double eta) {
  return shape_functions(static_cast<int>(node.cols()), xi, eta).derivative * node.transpose();
}

/// The modes 1 - xi^2 and 1 - eta^2 with the gradient that Taylor, Beresford and Wilson (1976) gave them, from the
/// Jacobian at the centre, so that they do no work on a constant stress and the patch test holds on any quadrilateral.
Gradients internal_gradients(const ElementNodes& node, const IntegrationPoint& at) {
  const Eigen::Matrix2d centre = jacobian(node, 0, 0);
  Eigen::Matrix2d local;
  local << -2 * at.xi, 0, 0, -2 * at.eta;
  return centre.determinant() / jacobian(node, at.xi, at.eta).determinant() * (centre.inverse() * local);
}

/// Hughes' B-bar (1980), volumetric third of the three-dimensional strain: the dilatation of every point is replaced by
/// its mean over the element, eps_bar = eps + (mean - tr eps) / 3 on the diagonal, eps_z included.
void average_dilatation(std::vector<IntegrationPoint>& points) {
  const auto trace = [](const IntegrationPoint& p) { return p.strain.row(0) + p.strain.row(1); };
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(points.front().strain.cols());
  double volume = 0;
  for (const auto& p : points) mean += p.volume * trace(p), volume += p.volume;
  mean /= volume;
  for (auto& p : points) {
    const Eigen::RowVectorXd third = (mean - trace(p)) / 3;
    for (int i : {0, 1, 3}) p.strain.row(i) += third;
  }
}

std::vector<IntegrationPoint> integration_points(Element element, const ElementNodes& node, int per_direction) {
  std::vector<IntegrationPoint> points;
  for (const GaussPoint& g : gauss_points(per_direction)) {
    const Eigen::Matrix2d j = jacobian(node, g.xi, g.eta);
    IntegrationPoint p{g.xi, g.eta, g.weight * j.determinant(), {}};
    Gradients gradient = j.inverse() * shape_functions(static_cast<int>(node.cols()), g.xi, g.eta).derivative;
    if (element == Element::q4i) {
      gradient.conservativeResize(2, 4 + internal_modes);
      gradient.rightCols<internal_modes>() = internal_gradients(node, p);
    }
    p.strain = strain_operator(gradient);
    points.push_back(p);
  }
  if (element == Element::bbar) average_dilatation(points);
  return points;
}

/// [all, all]: integral of B^T D B, internal amplitudes included.
Eigen::MatrixXd integrate(const std::vector<IntegrationPoint>& points, const Material& material) {
  const Eigen::Matrix4d d = elasticity(material);
  const Eigen::Index size = points.front().strain.cols();
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(size, size);
  for (const auto& p : points) k += p.volume * p.strain.transpose() * d * p.strain;
  return (k + k.transpose()) / 2;
}

/// Amplitudes of the internal modes that the nodal displacements bring about, [internal, 2 nodes]: they do no work.
Eigen::MatrixXd internal_amplitudes(const Eigen::MatrixXd& k, Eigen::Index outer) {
  const Eigen::Index inner = k.rows() - outer;
  return -k.bottomRightCorner(inner, inner).llt().solve(k.bottomLeftCorner(inner, outer));
}

}  // namespace

Material material(const Sensor& sensor, double height) {
  require_compressible(sensor);
  const auto [thickness, young, poisson] = rubber_at(sensor, height);
  return {young / (2 * (1 + poisson)), young / (3 * (1 - 2 * poisson))};
}

int nodes_per_element(Element element) { return element == Element::q8 ? 8 : 4; }

ElementStiffness element_stiffness(Element element, const ElementNodes& node, const Material& material) {
  const int per_direction = element == Element::q8 ? 3 : 2;
  const Eigen::MatrixXd k = integrate(integration_points(element, node, per_direction), material);
  const Eigen::Index outer = 2 * node.cols(), inner = k.rows() - outer;
  if (inner == 0) return k;
  const Eigen::MatrixXd condensed =
      k.topLeftCorner(outer, outer) + k.topRightCorner(outer, inner) * internal_amplitudes(k, outer);
  return (condensed + condensed.transpose()) / 2;
}

ElementStress element_nodal_stress(Element element, const ElementNodes& node, const Material& material) {
  const auto points = integration_points(element, node, 2);
  const Eigen::Index outer = 2 * node.cols(), inner = points.front().strain.cols() - outer;
  Eigen::MatrixXd from_nodes = Eigen::MatrixXd::Identity(outer + inner, outer);
  if (inner > 0) from_nodes.bottomRows(inner) = internal_amplitudes(integrate(points, material), outer);
  const Eigen::Matrix4d d = elasticity(material);
  const Eigen::Matrix2Xd at = node_coordinates(static_cast<int>(node.cols()));
  // The Gauss points stand at xi, eta = -+1/sqrt(3), in an order of their own; seen from them the nodes stand at
  // sqrt(3) times theirs.
  constexpr int corner_of_point[] = {0, 1, 3, 2};
  ElementStress stress = ElementStress::Zero(4 * node.cols(), outer);
  for (Eigen::Index k = 0; k < node.cols(); ++k) {
    const auto weight = shape_functions(4, std::sqrt(3.0) * at(0, k), std::sqrt(3.0) * at(1, k)).value;
    for (std::size_t p = 0; p < points.size(); ++p)
      stress.middleRows<4>(4 * k) += weight[corner_of_point[p]] * (d * points[p].strain * from_nodes);
  }
  return stress;
}

}  // namespace tactel::fem
