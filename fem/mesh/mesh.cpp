// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/mesh.h"

#include <cmath>

namespace tactel::fem {
namespace {

/// Moves the rows nearest to interfaces of layers there, and those between in proportion. y: [rows] mm.
void meet_interfaces(const Sensor& sensor, Eigen::VectorXd& y) {
  const Eigen::VectorXd even = y;
  Eigen::Index below = 0, left = static_cast<Eigen::Index>(sensor.layers.size());
  for (const RubberLayer& layer : sensor.layers) {
    const Eigen::Index last = y.size() - left;  // each further layer has a row of elements
    const double top = --left == 0 ? sensor.thickness : y[below] + layer.thickness;
    Eigen::Index row = below + 1;
    while (row < last && even[row] + even[row + 1] < 2 * top) ++row;
    for (Eigen::Index j = below + 1; j <= row; ++j)
      y[j] = y[below] + (top - y[below]) * (even[j] - even[below]) / (even[row] - even[below]);
    y[below = row] = top;
  }
}

/// Heights at which the corner nodes' rows lie, [rows] mm: row heights fall geometrically from the base to the surface.
Eigen::VectorXd row_heights(const Sensor& sensor) {
  const int intervals = sensor.rows - 1;
  Eigen::VectorXd y = Eigen::VectorXd::Zero(sensor.rows);
  for (int j = 0; j < intervals; ++j)
    y[j + 1] = y[j] + std::pow(sensor.grading, -static_cast<double>(j) / std::max(1, intervals - 1));
  y *= sensor.thickness / y[intervals];
  y[intervals] = sensor.thickness;
  meet_interfaces(sensor, y);
  return y;
}

/// Node numbers of the structured mesh: corners row by row from the base, then (q8) the middles of horizontal edges row
/// by row, then the middles of vertical edges.
struct Numbering {
  int columns, rows;
  int corner(int i, int j) const { return j * columns + i; }
  int corners() const { return columns * rows; }
  int horizontal(int i, int j) const { return corners() + j * (columns - 1) + i; }
  int vertical(int i, int j) const { return corners() + (columns - 1) * rows + j * columns + i; }
  int with_mid_sides() const { return vertical(0, rows - 1); }
};

void place_corners(const Numbering& number, const Eigen::VectorXd& x, const Eigen::VectorXd& y, Mesh& mesh) {
  for (int j = 0; j < number.rows; ++j)
    for (int i = 0; i < number.columns; ++i) mesh.node.col(number.corner(i, j)) << x[i], y[j];
}

void place_mid_sides(const Numbering& number, const Eigen::VectorXd& x, const Eigen::VectorXd& y, Mesh& mesh) {
  for (int j = 0; j < number.rows; ++j)
    for (int i = 0; i + 1 < number.columns; ++i) mesh.node.col(number.horizontal(i, j)) << (x[i] + x[i + 1]) / 2, y[j];
  for (int j = 0; j + 1 < number.rows; ++j)
    for (int i = 0; i < number.columns; ++i) mesh.node.col(number.vertical(i, j)) << x[i], (y[j] + y[j + 1]) / 2;
}

void connect(const Numbering& number, bool mid_sides, Mesh& mesh) {
  mesh.cell.resize((number.columns - 1) * (number.rows - 1), mid_sides ? 8 : 4);
  for (int j = 0, k = 0; j + 1 < number.rows; ++j)
    for (int i = 0; i + 1 < number.columns; ++i, ++k) {
      mesh.cell.row(k).head<4>() << number.corner(i, j), number.corner(i + 1, j), number.corner(i + 1, j + 1),
          number.corner(i, j + 1);
      if (mid_sides)
        mesh.cell.row(k).tail<4>() << number.horizontal(i, j), number.vertical(i + 1, j), number.horizontal(i, j + 1),
            number.vertical(i, j);
    }
}

}  // namespace

Mesh make_mesh(const Sensor& sensor) {
  validate(sensor);
  const bool mid_sides = sensor.element == Element::q8;
  const Numbering number{sensor.columns, sensor.rows};
  const Eigen::VectorXd x = surface_positions(sensor), y = row_heights(sensor);
  Mesh mesh;
  mesh.element = sensor.element;
  mesh.node.resize(2, mid_sides ? number.with_mid_sides() : number.corners());
  place_corners(number, x, y, mesh);
  if (mid_sides) place_mid_sides(number, x, y, mesh);
  connect(number, mid_sides, mesh);
  for (int i = 0; i < sensor.columns; ++i) {
    mesh.surface.push_back(number.corner(i, sensor.rows - 1));
    mesh.base.push_back(number.corner(i, 0));
    if (mid_sides && i + 1 < sensor.columns) mesh.base.push_back(number.horizontal(i, 0));
  }
  return mesh;
}

std::vector<int> unknowns_of(const std::vector<int>& nodes) {
  std::vector<int> unknowns(2 * nodes.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i) unknowns[i] = 2 * nodes[i / 2] + static_cast<int>(i % 2);
  return unknowns;
}

}  // namespace tactel::fem
