// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/base_stress_table.h"

#include <algorithm>
#include <cmath>

#include "fem/mesh/block.h"

namespace tactel::fem {
namespace {

/// Stress at x / h from a force, and its mean over a width.
BaseStress stress_over(const LayerTable& table, double x, double width) {
  if (width == 0) return table.base(x);
  const BaseStress to = table.base_integral(x + width / 2), from = table.base_integral(x - width / 2);
  return {(to.sigma_by_y - from.sigma_by_y) / width, (to.tau_by_x - from.tau_by_x) / width,
          (to.tau_by_y - from.tau_by_y) / width, (to.sigma_by_x - from.sigma_by_x) / width};
}

}  // namespace

BaseStressTable::BaseStressTable(int tactels, std::function<Eigen::RowVectorXd(double)> rows)
    : tactels_(tactels), exact_(std::move(rows)) {}

Eigen::Index BaseStressTable::places(const Sensor& sensor) {
  return static_cast<Eigen::Index>(std::ceil(sensor.length / sensor.thickness * rows_a_thickness)) + 1;
}

BaseStressTable::BaseStressTable(const Sensor& sensor, Rows rows)
    : tactels_(sensor.tactels),
      left_(-sensor.length / 2),
      step_(sensor.length / static_cast<double>(rows.rows() - 1)),
      rows_(std::move(rows)) {}

BaseStressTable::BaseStressTable(const Sensor& sensor, const LayerTable& table)
    : BaseStressTable(sensor, Rows(places(sensor), quantities * sensor.tactels)) {
  const double h = sensor.thickness;
  const Eigen::VectorXd tactel = tactel_positions(sensor);
  const Eigen::Index count = tactel.size();
  for (Eigen::Index row = 0; row < rows_.rows(); ++row)
    for (Eigen::Index k = 0; k < count; ++k) {
      const double distance = tactel[k] - (left_ + static_cast<double>(row) * step_);
      const BaseStress s = stress_over(table, distance / h, sensor.tactel_width / h);
      rows_(row, sigma_by_pressure * count + k) = -s.sigma_by_y / h;
      rows_(row, sigma_by_traction * count + k) = s.sigma_by_x / h;
      rows_(row, tau_by_pressure * count + k) = -s.tau_by_y / h;
      rows_(row, tau_by_traction * count + k) = s.tau_by_x / h;
    }
}

void BaseStressTable::add(const std::function<Eigen::RowVectorXd(double)>& rows) {
  for (Eigen::Index row = 0; row < rows_.rows(); ++row)
    rows_.row(row) += rows(left_ + static_cast<double>(row) * step_);
}

Eigen::RowVectorXd BaseStressTable::at(double x) const {
  if (exact_) return exact_(x);
  const double last = static_cast<double>(rows_.rows() - 1), place = std::clamp((x - left_) / step_, 0.0, last);
  const Eigen::Index row = std::min(static_cast<Eigen::Index>(place), rows_.rows() - 2);
  const double q = place - static_cast<double>(row);
  return rows_.row(row) + q * (rows_.row(row + 1) - rows_.row(row));
}

Eigen::VectorXd BaseStressTable::stress(const Eigen::VectorXd& x, const Eigen::VectorXd& pressure_force,
                                        const Eigen::VectorXd& traction_force) const {
  const Eigen::Index count = tactels();
  Eigen::VectorXd stress = Eigen::VectorXd::Zero(2 * count);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (pressure_force[i] == 0 && traction_force[i] == 0) continue;
    const Eigen::VectorXd row = at(x[i]);
    stress.head(count) += row.segment(sigma_by_pressure * count, count) * pressure_force[i] +
                          row.segment(sigma_by_traction * count, count) * traction_force[i];
    stress.tail(count) += row.segment(tau_by_pressure * count, count) * pressure_force[i] +
                          row.segment(tau_by_traction * count, count) * traction_force[i];
  }
  return stress;
}

}  // namespace tactel::fem
