// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/long_layer.h"

#include <algorithm>
#include <complex>
#include <numbers>
#include <stdexcept>

#include "fem/mesh/elements.h"
#include "fem/mesh/mesh.h"
#include "fem/scenes/rubber.h"

namespace tactel::fem {
namespace {

using Complex = std::complex<double>;

/// Answers fall like e^(-0.75 x / h), or as far as layers carry shear: to rounding within this many lengths.
constexpr double reach = 30, lengths = 22.5;

/// Stiffness between the unknowns of one column and of the next, [2 rows, 2 rows]: K(theta) = own + e^(i theta) next +
/// e^(-i theta) next^T. Unknowns 2j (x) and 2j + 1 (y) of row j from the base.
struct ColumnStiffness {
  Eigen::MatrixXd own, next;
};

ColumnStiffness column_stiffness(const Sensor& sensor) {
  Sensor narrow = with_unit_young(sensor);
  narrow.columns = 3;
  narrow.length = 2 * sensor.length / (sensor.columns - 1);
  narrow.tactels = 2;
  narrow.tactel_span.reset();
  narrow.tactel_width = 0;
  const Mesh mesh = make_mesh(narrow);
  const Eigen::Index size = 2 * sensor.rows;
  ColumnStiffness column{Eigen::MatrixXd::Zero(size, size), Eigen::MatrixXd::Zero(size, size)};
  for (int j = 0; j + 1 < sensor.rows; ++j) {
    const ElementNodes node = mesh.node(Eigen::all, mesh.cell.row(2 * j));
    const ElementStiffness k = element_stiffness(mesh.element, node, material(narrow, node.row(1).mean()));
    const int row[] = {j, j, j + 1, j + 1};  // of the corners, counter-clockwise from the lower left
    const bool right[] = {false, true, true, false};
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        if (right[a] && !right[b]) continue;  // the transpose of what is kept
        auto& part = right[a] == right[b] ? column.own : column.next;
        part.block<2, 2>(2 * row[a], 2 * row[b]) += k.block<2, 2>(2 * a, 2 * b);
      }
  }
  return column;
}

/// One wavenumber: [2, 2] displacement of the surface and force on the base by a force on the surface.
struct Answer {
  Eigen::Matrix2cd surface, base;
};

Answer answer(const ColumnStiffness& column, Complex phase) {
  const Eigen::Index size = column.own.rows();
  const Eigen::MatrixXcd K = column.own + phase * column.next + std::conj(phase) * column.next.transpose();
  Eigen::MatrixXcd force = Eigen::MatrixXcd::Zero(size - 2, 2);
  force.bottomRows<2>().setIdentity();
  const Eigen::MatrixXcd u = K.bottomRightCorner(size - 2, size - 2).partialPivLu().solve(force);
  return {u.bottomRows<2>(), -K.topRightCorner(2, size - 2) * u};
}

}  // namespace

LongLayer long_layer(const Sensor& sensor, int columns) {
  if (sensor.element == Element::q8) throw std::invalid_argument("long_layer: elements with mid-side nodes; use bbar");
  const double spacing = sensor.length / (sensor.columns - 1);
  const double far = std::max(reach, lengths * shear_length(sensor.layers));
  const int period = 2 * (columns + static_cast<int>(far * sensor.thickness / spacing));
  const ColumnStiffness column = column_stiffness(sensor);
  LongLayer layer;
  layer.spacing = spacing;
  Eigen::VectorXd* const results[] = {&layer.yy,       &layer.xx,       &layer.xy,        &layer.sigma_by_y,
                                      &layer.tau_by_x, &layer.tau_by_y, &layer.sigma_by_x};
  for (Eigen::VectorXd* result : results) *result = Eigen::VectorXd::Zero(columns + 1);
  for (int m = 0; m <= period / 2; ++m) {
    const double theta = 2 * std::numbers::pi * m / period;
    const double weight = (m == 0 || 2 * m == period ? 1.0 : 2.0) / period;  // theta and -theta are conjugate
    const Answer a = answer(column, std::polar(1.0, theta));
    const double mass = spacing * (2 + std::cos(theta)) / 3;  // consistent mass of the base edge
    for (int k = 0; k <= columns; ++k) {
      const Complex wave = weight * std::polar(1.0, theta * k), stress = wave / mass;
      layer.yy[k] += (a.surface(1, 1) * wave).real();
      layer.xx[k] += (a.surface(0, 0) * wave).real();
      layer.xy[k] += (a.surface(0, 1) * wave).real();
      layer.sigma_by_y[k] += (a.base(1, 1) * stress).real();
      layer.tau_by_x[k] += (a.base(0, 0) * stress).real();
      layer.tau_by_y[k] += (a.base(0, 1) * stress).real();
      layer.sigma_by_x[k] += (a.base(1, 0) * stress).real();
    }
  }
  return layer;
}

}  // namespace tactel::fem
