// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <functional>

#include "fem/layer/layer_table.h"
#include "fem/scenes/sensor.h"

namespace tactel::fem {

/// Stress at a sensor's tactels by a unit line force on the surface, as a table over the place of the force: 1/mm
/// (MPa per N/mm), free of E. A tactel with a width takes the mean over it. Linear between the rows.
class BaseStressTable {
 public:
  static constexpr int rows_a_thickness = 30;

  /// Columns of a row: [quantity][tactel].
  enum Quantity { sigma_by_pressure, sigma_by_traction, tau_by_pressure, tau_by_traction, quantities };
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Of an endless layer.
  BaseStressTable(const Sensor& sensor, const LayerTable& table);

  /// Of rows as rows() returned them.
  BaseStressTable(const Sensor& sensor, Rows rows);

  /// Of `rows(x)` [4 tactels] at every x, without a table.
  BaseStressTable(int tactels, std::function<Eigen::RowVectorXd(double x)> rows);

  /// Returns the rows of a table for this sensor.
  static Eigen::Index places(const Sensor& sensor);

  /// Adds `rows(x)` [4 tactels], what the free sides change, to the row at x, mm along the array.
  void add(const std::function<Eigen::RowVectorXd(double x)>& rows);

  /// Returns the row [4 tactels] for forces at x, mm along the array.
  Eigen::RowVectorXd at(double x) const;

  /// Returns sigma_y of every tactel, then tau_xy [2 tactels] MPa, by pressure and traction forces [places] N/mm at
  /// places [places] mm.
  Eigen::VectorXd stress(const Eigen::VectorXd& x, const Eigen::VectorXd& pressure_force,
                         const Eigen::VectorXd& traction_force) const;

  int tactels() const { return tactels_; }
  double left() const { return left_; }
  double step() const { return step_; }
  const Rows& rows() const { return rows_; }  ///< [places, 4 tactels], the first at `left`, `step` apart

 private:
  int tactels_;
  double left_ = 0, step_ = 1;
  Rows rows_;
  std::function<Eigen::RowVectorXd(double x)> exact_;
};

}  // namespace tactel::fem
