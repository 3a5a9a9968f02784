// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/press_readings.h"

#include <fmt/format.h>

#include <algorithm>

#include "fem/value_error.h"

namespace tactel::host {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {
constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
constexpr double outlier = 3;  ///< standard deviations, from which Huber's loss is linear
}  // namespace

PressReadings::PressReadings(const std::vector<KnownPress>& measured, const CalibrationOptions& options)
    : presses(measured),
      tactels(0),
      force_noise(options.force_noise),
      given_noise(options.noise),
      press_used(measured.size(), true) {
  if (presses.empty()) throw ValueError("presses", "none", "at least one known press");
  const AnyScene& first = presses.front().scene;
  const Index count = channels_of(first);
  tactels = tactels_of(first);
  Index total = 0;
  for (const KnownPress& press : presses) {
    if (press.scene.index() != first.index())
      throw ValueError(press.name + ": sensor.kind", "another", "that of " + presses.front().name);
    if (press.readings.cols() != count || press.readings.rows() == 0 ||
        (press.P.size() > 0 && press.P.size() != press.readings.rows()))
      throw ValueError(press.name + ": readings", fmt::format("{} x {}", press.readings.rows(), press.readings.cols()),
                       fmt::format("one row for each load step, {} columns", count));
    if (std::isfinite(options.time_constant)) press.timing.validate(static_cast<std::size_t>(press.readings.rows()));
    first_row.push_back(total);
    total += press.readings.rows();
  }
  value.resize(total, count);
  P.setConstant(total, left_out);
  for (std::size_t i = 0; i < presses.size(); ++i) {
    value(rows(i), Eigen::all) = presses[i].readings;
    if (presses[i].P.size() > 0) P(rows(i)) = presses[i].P;
  }
  weight = MatrixXd::Ones(total, count);
  P_weight = VectorXd::Ones(static_cast<Index>(presses.size()));
  channels.resize(static_cast<std::size_t>(count));
  for (Channel& channel : channels) channel.used = true;
}

void PressReadings::fit_channels(const MatrixXd& frame, bool renew_noise, std::vector<CalibrationFault>& faults) {
  for (Index c = 0; c < count(); ++c) {
    Channel& channel = channels[static_cast<std::size_t>(c)];
    if (!channel.used) continue;
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (Index row = 0; row < rows(); ++row) {
      if (!takes(row, c)) continue;
      const double w = weight(row, c), x = frame(row, c), y = value(row, c);
      normal(0, 0) += w, normal(0, 1) += w * x, normal(1, 1) += w * x * x;
      right[0] += w * y, right[1] += w * x * y;
    }
    normal(1, 0) = normal(0, 1);
    const double determinant = normal.determinant();
    if (!(determinant > 1e-12 * normal(0, 0) * normal(1, 1))) {
      channel.used = false;
      faults.push_back({CalibrationFault::Kind::dead_channel,
                        transducer_name(c, count(), tactels) + ": no press changes its stress; it has no gain", c});
      continue;
    }
    const Eigen::Vector2d fitted = normal.inverse() * right;
    channel.offset = fitted[0], channel.sensitivity = fitted[1];
    if (renew_noise) {
      double sum = 0, n = -2;
      channel.noise = 1;
      for (Index row = 0; row < rows(); ++row)
        if (takes(row, c)) {
          const double r = residual(row, c, frame(row, c));
          sum += weight(row, c) * r * r;
          n += 1;
        }
      channel.noise = std::sqrt(sum / std::max(1.0, n));
      if (given_noise.size() > 0) channel.noise = std::max(channel.noise, given_noise[c]);
      if (!(channel.noise > 0)) channel.noise = 1e-12 * std::max(1.0, std::abs(channel.offset));
    }
    channel.inverse = normal.inverse() * channel.noise * channel.noise;
  }
}

void PressReadings::reweight(const MatrixXd& frame, const VectorXd& forces) {
  const auto huber = [](double r) { return std::abs(r) <= outlier ? 1 : outlier / std::abs(r); };
  for (Index c = 0; c < count(); ++c)
    for (Index row = 0; row < rows(); ++row)
      if (takes(row, c)) weight(row, c) = huber(residual(row, c, frame(row, c)));
  for (std::size_t i = 0; i < presses.size(); ++i)
    if (has_force(i)) P_weight[static_cast<Index>(i)] = huber(force_residual(i, forces(rows(i))));
}

bool PressReadings::has_force(std::size_t press) const {
  return (P(rows(press)).array() > 0 && P(rows(press)).array().isFinite()).any();
}

double PressReadings::over_measured(std::size_t press, const VectorXd& forces) const {
  double sum = 0, n = 0;
  for (Index step = 0; step < steps(press); ++step)
    if (const Index row = first_row[press] + step; takes_force(row)) sum += forces[step] / P[row], n += 1;
  return n > 0 ? sum / n : 0;
}

MatrixXd PressReadings::residuals(std::size_t press, const MatrixXd& frame) const {
  MatrixXd all = MatrixXd::Constant(steps(press), count(), left_out);
  for (Index step = 0; step < steps(press); ++step)
    for (Index c = 0; c < count(); ++c)
      if (const Index row = first_row[press] + step; takes(row, c)) all(step, c) = residual(row, c, frame(step, c));
  return all;
}

double PressReadings::squares(std::size_t press, const MatrixXd& frame, const VectorXd& forces) const {
  const Eigen::ArrayXXd off = residuals(press, frame).array();
  double sum = off.isNaN().select(0, weight(rows(press), Eigen::all).array() * off.square()).sum();
  if (has_force(press)) sum += P_weight[static_cast<Index>(press)] * std::pow(force_residual(press, forces), 2);
  return sum;
}

void PressReadings::leave_out_press(std::size_t press) {
  press_used[press] = false;
  value(rows(press), Eigen::all).setConstant(left_out);
  P(rows(press)).setConstant(left_out);
}

}  // namespace tactel::host
