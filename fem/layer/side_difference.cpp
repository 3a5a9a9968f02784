// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/side_difference.h"

#include <algorithm>
#include <cmath>

#include "fem/layer/long_layer.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem {
namespace {

constexpr int columns_a_thickness = 12, rows_of_block = 25, least_columns = 41;

double at(const Eigen::VectorXd& even, Eigen::Index k) { return even[std::abs(k)]; }
double odd(const Eigen::VectorXd& values, Eigen::Index k) { return k < 0 ? -values[-k] : values[k]; }

/// C of the endless layer between all surface nodes, [2 columns, 2 columns].
Eigen::MatrixXd endless_compliance(const LongLayer& layer, Eigen::Index columns) {
  Eigen::MatrixXd c(2 * columns, 2 * columns);
  for (Eigen::Index i = 0; i < columns; ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      c.block<2, 2>(2 * i, 2 * j) << at(layer.xx, i - j), odd(layer.xy, i - j), -odd(layer.xy, i - j),
          at(layer.yy, i - j);
  return c;
}

/// Base stress of the endless layer, [2 columns, 2 columns].
Eigen::MatrixXd endless_base(const LongLayer& layer, Eigen::Index columns) {
  Eigen::MatrixXd stress(2 * columns, 2 * columns);
  for (Eigen::Index i = 0; i < columns; ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      stress.block<2, 2>(2 * i, 2 * j) << at(layer.tau_by_x, i - j), odd(layer.tau_by_y, i - j),
          odd(layer.sigma_by_x, i - j), at(layer.sigma_by_y, i - j);
  return stress;
}

/// Consistent mass of a base edge of linear elements with equal spacing, [nodes, nodes] mm.
Eigen::MatrixXd base_mass(Eigen::Index nodes, double spacing) {
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(nodes, nodes);
  for (Eigen::Index i = 0; i + 1 < nodes; ++i) {
    mass(i, i) += spacing / 3;
    mass(i + 1, i + 1) += spacing / 3;
    mass(i, i + 1) = mass(i + 1, i) = spacing / 6;
  }
  return mass;
}

/// Base stress from base forces [2 nodes, loads], both directions by the same mass.
Eigen::MatrixXd base_stress(const Eigen::MatrixXd& force, double spacing) {
  const Eigen::LLT<Eigen::MatrixXd> mass(base_mass(force.rows() / 2, spacing));
  Eigen::MatrixXd stress(force.rows(), force.cols());
  for (const int component : {0, 1}) {
    const auto rows = Eigen::seq(component, Eigen::last, 2);
    const Eigen::MatrixXd along = force(rows, Eigen::all), density = mass.solve(along);
    stress(rows, Eigen::all) = density;
  }
  return stress;
}

/// Columns of the inner nodes, each the (1, 2, 1)/4 mean over a node and its neighbours.
Eigen::MatrixXd spread_over_neighbours(const Eigen::MatrixXd& by_node) {
  const Eigen::Index inner = by_node.cols() - 4;
  return (by_node.leftCols(inner) + 2 * by_node.middleCols(2, inner) + by_node.rightCols(inner)) / 4;
}

}  // namespace

Sensor side_block(const Sensor& sensor) {
  const Sensor unit = with_unit_young(sensor, most_poisson_of_block);
  Sensor block;
  block.length = std::min(sensor.length, longest_side_block * sensor.thickness);
  block.thickness = sensor.thickness;
  block.young = unit.young, block.poisson = unit.poisson, block.layers = unit.layers;
  constexpr int half = columns_a_thickness / 2;
  block.columns = std::max(least_columns, 2 * static_cast<int>(std::lround(half * block.length / block.thickness)) + 1);
  block.rows = rows_of_block;
  block.tactels = 2;
  return block;
}

SideDifference side_difference(const Sensor& block, const std::filesystem::path& cache_directory) {
  const Condensation condensed = condense_cached(block, cache_directory);
  const Eigen::Index columns = block.columns, inner = columns - 2;
  const LongLayer layer = long_layer(block, block.columns);
  const Eigen::MatrixXd compliance = condensed.compliance - endless_compliance(layer, columns);
  const Eigen::MatrixXd base = base_stress(condensed.base_force, layer.spacing) - endless_base(layer, columns);
  return {block.thickness, condensed.surface_x.segment(1, inner), compliance.block(2, 2, 2 * inner, 2 * inner),
          condensed.base_x, spread_over_neighbours(base)};
}

}  // namespace tactel::fem
