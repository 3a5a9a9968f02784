// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "fem/mesh/block.h"
#include "fem/mesh/elements.h"
#include "fem/mesh/shape_functions.h"

namespace tactel::fem {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// [tactels, base nodes]: mean over the width of each tactel of a quantity given at the base nodes, by the edge's own
/// shape functions. Two Gauss points an edge are exact up to cubics.
Eigen::MatrixXd mean_over_tactels(const Mesh& mesh, const Sensor& sensor) {
  const int edges = sensor.columns - 1, per_edge = mesh.element == Element::q8 ? 3 : 2;
  const double edge_length = sensor.length / edges;
  const Eigen::VectorXd middle = tactel_positions(sensor);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(sensor.tactels, static_cast<Eigen::Index>(mesh.base.size()));
  for (int t = 0; t < sensor.tactels; ++t) {
    const double from = (middle[t] - sensor.tactel_width / 2 + sensor.length / 2) / edge_length;  // in edges
    const double to = from + sensor.tactel_width / edge_length;
    for (int edge = std::max(0, static_cast<int>(from)); edge < edges && edge < to; ++edge) {
      const double left = std::max(0.0, from - edge), right = std::min(1.0, to - edge);
      for (const double gauss : {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)})
        mean.block(t, edge * (per_edge - 1), 1, per_edge) +=
            (right - left) / 2 * edge_functions(per_edge, left + right - 1 + (right - left) * gauss);
    }
    mean.row(t) /= mean.row(t).sum();
  }
  return mean;
}

/// [tactels, base nodes]: value at the middle of each tactel. A tactel at a node, but for rounding, takes the value of
/// that node and of no other.
Eigen::MatrixXd value_at_tactels(const Mesh& mesh, const Sensor& sensor) {
  const int edges = sensor.columns - 1, per_edge = mesh.element == Element::q8 ? 3 : 2;
  const Eigen::VectorXd middle = tactel_positions(sensor);
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(sensor.tactels, static_cast<Eigen::Index>(mesh.base.size()));
  for (int t = 0; t < sensor.tactels; ++t) {
    const double place = (middle[t] / sensor.length + 0.5) * edges, node = std::round(place);  // in edges
    const double at = std::abs(place - node) < 1e-9 ? node : place;
    const int edge = std::clamp(static_cast<int>(at), 0, edges - 1);
    value.block(t, edge * (per_edge - 1), 1, per_edge) = edge_functions(per_edge, 2 * (at - edge) - 1);
  }
  return value;
}

/// [tactels, base nodes]: what the tactels feel of a quantity given at the base nodes.
Eigen::MatrixXd interpolation_to_tactels(const Mesh& mesh, const Sensor& sensor) {
  return sensor.tactel_width > 0 ? mean_over_tactels(mesh, sensor) : value_at_tactels(mesh, sensor);
}

/// Consistent mass of the base edge, integral of N_i N_j dx, [base nodes, base nodes] mm.
Eigen::MatrixXd base_edge_mass(const Mesh& mesh) {
  const bool quadratic = mesh.element == Element::q8;
  const int step = quadratic ? 2 : 1;
  Eigen::MatrixXd edge(step + 1, step + 1);  // of unit length
  if (quadratic)
    edge << 4, 2, -1, 2, 16, 2, -1, 2, 4;
  else
    edge << 10, 5, 5, 10;
  edge /= 30;
  const auto nodes = static_cast<Eigen::Index>(mesh.base.size());
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(nodes, nodes);
  for (Eigen::Index i = 0; i + step < nodes; i += step)
    mass.block(i, i, step + 1, step + 1) += edge * (mesh.node(0, mesh.base[static_cast<std::size_t>(i + step)]) -
                                                    mesh.node(0, mesh.base[static_cast<std::size_t>(i)]));
  return mass;
}

ElementStress stress_of_cell(const Mesh& mesh, Eigen::Index cell, const Sensor& sensor) {
  const ElementNodes node = mesh.node(Eigen::all, mesh.cell.row(cell));
  return element_nodal_stress(mesh.element, node, material(sensor, node.row(1).mean()));
}

/// How many elements meet at each node, [nodes].
Eigen::VectorXd elements_at_nodes(const Mesh& mesh) {
  Eigen::VectorXd count = Eigen::VectorXd::Zero(mesh.node.cols());
  for (const int node : mesh.cell.reshaped()) count[node] += 1;
  return count;
}

/// sigma_y of every base node, then tau_xy, from all displacements: mean over the elements that meet there.
/// [2 base nodes, 2 nodes] MPa/mm.
Eigen::SparseMatrix<double> base_node_stress(const Mesh& mesh, const Sensor& sensor) {
  const Eigen::VectorXd count = elements_at_nodes(mesh);
  const auto base_nodes = static_cast<int>(mesh.base.size());
  std::vector<int> place(static_cast<std::size_t>(mesh.node.cols()), -1);  // among the base nodes
  for (int k = 0; k < base_nodes; ++k) place[static_cast<std::size_t>(mesh.base[static_cast<std::size_t>(k)])] = k;
  Triplets entries;
  for (Eigen::Index c = 0; c < sensor.columns - 1; ++c) {  // the bottom row of cells comes first
    const ElementStress stress = stress_of_cell(mesh, c, sensor);
    for (Eigen::Index local = 0; local < mesh.cell.cols(); ++local) {
      const int node = mesh.cell(c, local), k = place[static_cast<std::size_t>(node)];
      if (k < 0) continue;
      for (Eigen::Index j = 0; j < stress.cols(); ++j) {
        const int unknown = 2 * mesh.cell(c, j / 2) + static_cast<int>(j % 2);
        entries.emplace_back(k, unknown, stress(4 * local + 1, j) / count[node]);
        entries.emplace_back(base_nodes + k, unknown, stress(4 * local + 2, j) / count[node]);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(2 * base_nodes, 2 * mesh.node.cols());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

Eigen::VectorXd tactel_positions(const Sensor& sensor) {
  const int gaps = sensor.tactels - 1;
  Eigen::VectorXd x(sensor.tactels);
  for (int t = 0; t <= gaps; ++t) x[t] = sensor.span() * (2 * t - gaps) / (2.0 * gaps);
  return x;
}

Eigen::MatrixXd base_stress_from_reaction(const Mesh& mesh, const Sensor& sensor) {
  return base_edge_mass(mesh).llt().solve(interpolation_to_tactels(mesh, sensor).transpose()).transpose();
}

Eigen::SparseMatrix<double> base_stress_from_elements(const Mesh& mesh, const Sensor& sensor) {
  const Eigen::MatrixXd along = interpolation_to_tactels(mesh, sensor);
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(2 * along.rows(), 2 * along.cols());
  both.topLeftCorner(along.rows(), along.cols()) = along;
  both.bottomRightCorner(along.rows(), along.cols()) = along;
  const Eigen::SparseMatrix<double> to_tactels = both.sparseView();
  return to_tactels * base_node_stress(mesh, sensor);
}

Eigen::Matrix4Xd nodal_stress(const Mesh& mesh, const Sensor& sensor, const Eigen::VectorXd& displacement) {
  Eigen::Matrix4Xd stress = Eigen::Matrix4Xd::Zero(4, mesh.node.cols());
  for (Eigen::Index c = 0; c < mesh.cell.rows(); ++c) {
    const Eigen::Matrix2Xd u = displacement.reshaped(2, mesh.node.cols())(Eigen::all, mesh.cell.row(c));
    const Eigen::VectorXd at_nodes = stress_of_cell(mesh, c, sensor) * u.reshaped();
    for (Eigen::Index local = 0; local < mesh.cell.cols(); ++local)
      stress.col(mesh.cell(c, local)) += at_nodes.segment<4>(4 * local);
  }
  return stress.array().rowwise() / elements_at_nodes(mesh).transpose().array();
}

}  // namespace tactel::fem
