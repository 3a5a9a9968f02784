// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/gap_sweep_tables.h"

#include <algorithm>
#include <cmath>

#include "kernels/shared/contact_layout.h"

namespace tactel::host {
template <class Real>
std::vector<Real> compliance_table(const Eigen::MatrixXd& c, bool friction) {
  const int columns = static_cast<int>(c.rows() / 2);
  const std::size_t parts = friction ? COMPLIANCE_PARTS : 1;
  std::vector<Real> table;
  table.reserve(parts * columns * columns);
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < columns; ++j) {
      double pair[COMPLIANCE_PARTS];
      pair[COMPLIANCE_UY_BY_N] = -c(2 * i + 1, 2 * j + 1);
      pair[COMPLIANCE_UY_BY_T] = c(2 * i + 1, 2 * j);
      pair[COMPLIANCE_UX_BY_N] = -c(2 * i, 2 * j + 1);
      pair[COMPLIANCE_UX_BY_T] = c(2 * i, 2 * j);
      for (std::size_t part = 0; part < parts; ++part) table.push_back(static_cast<Real>(pair[part]));
    }
  return table;
}

template <class Real>
std::vector<Real> node_table(const Eigen::MatrixXd& c) {
  const int columns = static_cast<int>(c.rows() / 2);
  std::vector<Real> table(static_cast<std::size_t>(columns) * NODE_ROWS);
  for (int i = 0; i < columns; ++i) {
    double rise_by_n = 0, rise_by_t = 0;
    for (int j = 0; j < columns; ++j) {
      if (j == i) continue;
      rise_by_n = std::max(rise_by_n, -c(2 * i + 1, 2 * j + 1));
      rise_by_t = std::max(rise_by_t, std::abs(c(2 * i + 1, 2 * j)));
    }
    constexpr double up = 1 + 1e-5;  // rounding to fp32 must not lower a bound
    Real* row = &table[static_cast<std::size_t>(i) * NODE_ROWS];
    row[NODE_N_PER_UY] = static_cast<Real>(1 / c(2 * i + 1, 2 * i + 1));
    row[NODE_T_PER_UX] = static_cast<Real>(1 / c(2 * i, 2 * i));
    row[NODE_UX_PER_N] = static_cast<Real>(-c(2 * i, 2 * i + 1));
    row[NODE_RISE_PER_N] = static_cast<Real>(up * rise_by_n);
    row[NODE_RISE_PER_T] = static_cast<Real>(up * rise_by_t);
  }
  return table;
}

template <class Real>
std::vector<Real> output_table(const Eigen::MatrixXd& map) {
  const std::size_t columns = map.cols() / 2, rows = map.rows(), blocks = (rows + ROW_BLOCK - 1) / ROW_BLOCK;
  std::vector<Real> table(blocks * columns * ROW_BLOCK * 2, Real(0));
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t j = 0; j < columns; ++j) {
      Real* entry = &table[((r / ROW_BLOCK * columns + j) * ROW_BLOCK + r % ROW_BLOCK) * 2];
      entry[0] = static_cast<Real>(-map(r, 2 * j + 1));
      entry[1] = static_cast<Real>(map(r, 2 * j));
    }
  return table;
}

template std::vector<float> compliance_table(const Eigen::MatrixXd&, bool);
template std::vector<double> compliance_table(const Eigen::MatrixXd&, bool);
template std::vector<float> node_table(const Eigen::MatrixXd&);
template std::vector<double> node_table(const Eigen::MatrixXd&);
template std::vector<float> output_table(const Eigen::MatrixXd&);
template std::vector<double> output_table(const Eigen::MatrixXd&);

}  // namespace tactel::host
