// SPDX-License-Identifier: Apache-2.0
#include "host/training/frame_floor.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/training/answered_rows.h"

namespace tactel::host {
namespace {

bool answered(const ChangedRows& rows, std::size_t row) {
  return rows.status[row] != over_tolerance && std::isfinite(rows.slip_index[row]);
}

/// The answered row of a contact and step.
std::optional<std::size_t> find(const ChangedRows& rows, std::uint64_t contact, std::uint32_t step) {
  auto row = static_cast<std::size_t>(std::ranges::lower_bound(rows.contact, contact) - rows.contact.begin());
  while (row < rows.contact.size() && rows.contact[row] == contact && rows.step[row] < step) ++row;
  const bool found = row < rows.contact.size() && rows.contact[row] == contact && rows.step[row] == step;
  return found && answered(rows, row) ? std::optional(row) : std::nullopt;
}

Eigen::Map<const Eigen::VectorXf> frame_of(const ChangedRows& rows, std::size_t row) {
  return {rows.frames.data() + row * static_cast<std::size_t>(rows.inputs), rows.inputs};
}

/// frames: [inputs, frames of a reading] MPa; j: [inputs x frames, numbers].
double linear_error(const Eigen::MatrixXd& frames, const Eigen::MatrixXd& j, const Eigen::VectorXd& g, double sigma,
                    double gain) {
  const double variance = sigma * sigma, gain2 = gain * gain;
  Eigen::MatrixXd precision = j.transpose() * j / variance;
  for (Eigen::Index t = 0; gain > 0 && t < frames.rows(); ++t) {  // of each transducer: Sherman, Morrison (1950)
    Eigen::VectorXd fj = Eigen::VectorXd::Zero(g.size());
    for (Eigen::Index m = 0; m < frames.cols(); ++m) fj += frames(t, m) * j.row(m * frames.rows() + t).transpose();
    precision -= gain2 / (variance * (variance + gain2 * frames.row(t).squaredNorm())) * fj * fj.transpose();
  }
  precision.diagonal().array() += 12;
  return std::sqrt(2 / std::numbers::pi * std::max(g.dot(precision.ldlt().solve(g)), 0.0));
}

double error_of(const ChangedRows& rows, std::span<const std::int64_t> places, double sigma, double gain) {
  const auto newest = static_cast<std::size_t>(places.front());
  const auto count = static_cast<Eigen::Index>(places.size());
  const auto numbers = static_cast<Eigen::Index>(rows.changes - 1);
  Eigen::MatrixXd frames = Eigen::MatrixXd::Zero(rows.inputs, count);
  for (Eigen::Index m = 0; m < count; ++m)
    if (places[m] >= 0) frames.col(m) = frame_of(rows, static_cast<std::size_t>(places[m])).cast<double>();
  Eigen::MatrixXd j = Eigen::MatrixXd::Zero(rows.inputs * count, numbers);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(numbers);
  for (Eigen::Index n = 0; n < numbers; ++n) {
    const auto moved = [&](std::int64_t place) {
      return find(rows, rows.contact[newest] + 1 + static_cast<std::uint64_t>(n),
                  rows.step[static_cast<std::size_t>(place)]);
    };
    if (!std::ranges::all_of(places, [&](std::int64_t place) { return place < 0 || moved(place); })) continue;
    for (Eigen::Index m = 0; m < count; ++m)
      if (places[m] >= 0)
        j.col(n).segment(m * rows.inputs, rows.inputs) =
            (frame_of(rows, *moved(places[m])).cast<double>() - frames.col(m)) / rows.shift;
    g(n) = (double{rows.slip_index[*moved(places.front())]} - double{rows.slip_index[newest]}) / rows.shift;
  }
  return linear_error(frames, j, g, sigma, gain);
}

}  // namespace

std::vector<double> linear_errors(const ChangedRows& rows, const Readings& readings) {
  std::vector<double> errors(readings.sigma.size());
  const std::size_t frames = errors.empty() ? 0 : readings.rows.size() / errors.size();
  for (std::size_t k = 0; k < errors.size(); ++k)
    errors[k] = error_of(rows, std::span(readings.rows).subspan(k * frames, frames), readings.sigma[k], readings.gain);
  return errors;
}

}  // namespace tactel::host
