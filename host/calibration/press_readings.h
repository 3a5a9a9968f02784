// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "host/calibration/sensor_calibration.h"

namespace tactel::host {

/// Linear fit of a channel: reading = offset + sensitivity stress.
struct Channel {
  bool used = false;
  double offset = std::numeric_limits<double>::quiet_NaN(), sensitivity = offset, noise = 1;
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();  ///< of the normal matrix, with weights over noise^2
};

/// Readings of all presses, one below the other, with their weights and the linear fit of each channel.
struct PressReadings {
  /// Throws ValueError for sizes that disagree. Keeps a reference to `measured`.
  PressReadings(const std::vector<KnownPress>& measured, const CalibrationOptions& options);

  Eigen::Index rows() const { return value.rows(); }
  Eigen::Index count() const { return value.cols(); }
  Eigen::Index steps(std::size_t press) const { return presses[press].readings.rows(); }
  auto rows(std::size_t press) const { return Eigen::seqN(first_row[press], steps(press)); }
  const Channel& channel(Eigen::Index c) const { return channels[static_cast<std::size_t>(c)]; }
  /// Whether the fit takes this reading, this force.
  bool takes(Eigen::Index row, Eigen::Index c) const { return channel(c).used && std::isfinite(value(row, c)); }
  bool takes_force(Eigen::Index row) const { return std::isfinite(P[row]) && P[row] > 0; }
  /// Reading less model, where the stress is `stress`, MPa, over the channel's noise.
  double residual(Eigen::Index row, Eigen::Index c, double stress) const {
    return (value(row, c) - channel(c).offset - channel(c).sensitivity * stress) / channel(c).noise;
  }
  /// Mean over the load steps of a press of `forces` [steps] over those measured, both N/mm: the gauge's error is one
  /// for them all. 0 where none is measured.
  double over_measured(std::size_t press, const Eigen::VectorXd& forces) const;
  bool has_force(std::size_t press) const;
  /// Measured forces of a press less those of the model, `forces` [steps] N/mm, over their noise.
  double force_residual(std::size_t press, const Eigen::VectorXd& forces) const {
    return (1 - over_measured(press, forces)) / force_noise;
  }
  /// Residuals of a press, [steps, channels], where the model has frames [steps, channels] MPa; NaN: left out.
  Eigen::MatrixXd residuals(std::size_t press, const Eigen::MatrixXd& frame) const;
  /// Weighted squares of the residuals of a press where the model has frames [steps, channels] MPa and forces [steps].
  double squares(std::size_t press, const Eigen::MatrixXd& frame, const Eigen::VectorXd& forces) const;
  /// Fits offset and sensitivity of each channel to `frame` [rows, channels], MPa; its noise, too, where it is renewed.
  /// Channels that no press changes become faults.
  void fit_channels(const Eigen::MatrixXd& frame, bool renew_noise, std::vector<CalibrationFault>& faults);
  /// Huber's weights, by frames and forces of the model.
  void reweight(const Eigen::MatrixXd& frame, const Eigen::VectorXd& forces);
  void leave_out_press(std::size_t press);

  const std::vector<KnownPress>& presses;
  Eigen::Index tactels;
  double force_noise;                   ///< relative, of a press
  Eigen::VectorXd given_noise;          ///< [channels] or empty
  std::vector<Eigen::Index> first_row;  ///< [presses]
  Eigen::MatrixXd value, weight;        ///< [rows, channels] the device's units; NaN: left out
  Eigen::VectorXd P;                    ///< [rows] N/mm; of a pad N
  Eigen::VectorXd P_weight;             ///< [presses]
  std::vector<Channel> channels;
  std::vector<bool> press_used;
};

}  // namespace tactel::host
