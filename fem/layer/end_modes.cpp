// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/end_modes.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "fem/layer/between_nodes.h"

namespace tactel::fem {
namespace {

/// The left half of a block's difference, by distance from its left end in thicknesses.
struct Half {
  Eigen::VectorXd surface, base;            ///< [nodes], [base nodes] h
  Eigen::MatrixXd compliance, base_stress;  ///< [2 nodes, 2 nodes] E = 1; [2 base nodes, 2 nodes] times h
};

Eigen::Index within(const Eigen::VectorXd& distance, double reach) {
  return std::count_if(distance.begin(), distance.end(), [&](double s) { return s <= reach + 1e-9; });
}

Half left_half(const SideDifference& difference) {
  const double h = difference.thickness, end = difference.base_x[0];
  const Eigen::VectorXd surface = (difference.x.array() - end) / h, base = (difference.base_x.array() - end) / h;
  const Eigen::Index nodes = within(surface, EndModes::reach), base_nodes = within(base, EndModes::reach);
  return {surface.head(nodes), base.head(base_nodes), difference.compliance.topLeftCorner(2 * nodes, 2 * nodes),
          h * difference.base.topLeftCorner(2 * base_nodes, 2 * nodes)};
}

/// The directions [rows, rank] that the columns of all matrices together use most.
Eigen::MatrixXd common_directions(const std::vector<Eigen::MatrixXd>& matrices) {
  Eigen::MatrixXd squares = matrices[0] * matrices[0].transpose();
  for (std::size_t k = 1; k < matrices.size(); ++k) squares += matrices[k] * matrices[k].transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(squares).eigenvectors().rightCols(EndModes::rank);
}

/// [nodes, 2 rank]: the y components of all modes, then the x components, from rows x at 2i, y at 2i + 1.
Eigen::MatrixXd by_node(const Eigen::MatrixXd& modes) {
  Eigen::MatrixXd rows(modes.rows() / 2, 2 * modes.cols());
  rows << modes(Eigen::seq(1, Eigen::last, 2), Eigen::all), modes(Eigen::seq(0, Eigen::last, 2), Eigen::all);
  return rows;
}

EndModes::Rows table(const Eigen::VectorXd& nodes, const Eigen::MatrixXd& modes) {
  const Eigen::MatrixXd rows = by_node(modes);
  constexpr int cells = EndModes::reach * EndModes::rows_a_thickness;
  EndModes::Rows fine = EndModes::Rows::Zero(cells + 1, rows.cols());
  for (int i = 0; i < cells; ++i)
    fine.row(i) = between_nodes(nodes, rows, static_cast<double>(i) / EndModes::rows_a_thickness);
  return fine;
}

}  // namespace

EndModes::EndModes(const std::vector<SideDifference>& differences) {
  std::vector<Half> halves;
  std::ranges::transform(differences, std::back_inserter(halves), left_half);
  const Half& first = halves.front();
  // The corner is singular; without a weight the modes would serve it alone (free_sides.h).
  Eigen::VectorXd weight(first.compliance.rows());
  for (Eigen::Index i = 0; i < weight.size(); ++i) weight[i] = std::sqrt(std::min(1.0, first.surface[i / 2] / 2));
  std::vector<Eigen::MatrixXd> weighted, by_force, by_stress;
  for (const Half& half : halves) {
    weighted.emplace_back(weight.asDiagonal() * half.compliance * weight.asDiagonal());
    by_stress.emplace_back(half.base_stress * weight.asDiagonal());
    by_force.emplace_back(by_stress.back().transpose());
  }
  const Eigen::MatrixXd u = common_directions(weighted), stresses = common_directions(by_stress),
                        forces = common_directions(by_force), per_weight = weight.cwiseInverse().asDiagonal();
  for (std::size_t k = 0; k < halves.size(); ++k) {
    compliance.emplace_back(u.transpose() * weighted[k] * u);
    base_stress.emplace_back(stresses.transpose() * by_stress[k] * forces);
  }
  displacement = table(first.surface, per_weight * u);
  force = table(first.surface, per_weight * forces);
  stress = table(first.base, stresses);
}

Eigen::RowVectorXd EndModes::at(const Rows& rows, double distance) {
  const double last = static_cast<double>(rows.rows() - 1);
  const double place = std::clamp(distance * rows_a_thickness, 0.0, last);
  const Eigen::Index row = std::min(static_cast<Eigen::Index>(place), rows.rows() - 2);
  return rows.row(row) + (place - static_cast<double>(row)) * (rows.row(row + 1) - rows.row(row));
}

}  // namespace tactel::fem
