// SPDX-License-Identifier: Apache-2.0
#include "nn/frame_likelihood.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "fem/value_error.h"
#include "nn/noise_words.h"

namespace tactel::nn {

void ReadingModel::validate() const {
  if (!(noise > 0 && std::isfinite(noise)))
    throw ValueError("noise", std::to_string(noise), "above 0: without noise every frame is told from every other");
  if (!(gain >= 0 && std::isfinite(gain))) throw ValueError("gain", std::to_string(gain), "finite and at least 0");
  if (history < 1) throw ValueError("history", std::to_string(history), "at least 1 frame");
}

double deviation(const ReadingModel& model, std::span<const float> truth, double largest) {
  if (largest > 0) return model.noise * largest;
  for (const float f : truth.first(static_cast<std::size_t>(model.inputs)))
    largest = std::max(largest, std::abs(static_cast<double>(f)));
  return model.noise * largest;
}

double log_likelihood(const ReadingModel& model, std::span<const float> truth, std::span<const float> reading,
                      double largest) {
  const double sigma = deviation(model, truth, largest), gain2 = model.gain * model.gain;
  double sum = -model.size() * std::log(sigma);
  for (int t = 0; t < model.inputs; ++t) {
    double rr = 0, rf = 0, ff = 0;  // of residual r and frames f, over sigma^2
    for (int m = 0; m < model.history; ++m) {
      const std::size_t at =
          static_cast<std::size_t>(m) * static_cast<std::size_t>(model.inputs) + static_cast<std::size_t>(t);
      const double f = truth[at] / sigma, r = reading[at] / sigma - f;
      rr += r * r, rf += r * f, ff += f * f;
    }
    const double determinant = 1 + gain2 * ff;
    sum -= 0.5 * (rr - gain2 / determinant * rf * rf + std::log(determinant));
  }
  return sum;
}

double linear_error(const ReadingModel& model, std::span<const float> truth, const RowMatrix<double>& j,
                    const Vector<double>& g, double largest) {
  const double variance = std::pow(deviation(model, truth, largest), 2), gain2 = model.gain * model.gain;
  Eigen::MatrixXd precision = j.transpose() * j / variance;
  for (int t = 0; t < model.inputs; ++t) {
    double ff = 0;
    Eigen::RowVectorXd fj = Eigen::RowVectorXd::Zero(j.cols());
    for (int m = 0; m < model.history; ++m) {
      const int at = m * model.inputs + t;
      const double f = truth[static_cast<std::size_t>(at)];
      ff += f * f;
      fj += f * j.row(at);
    }
    precision -= gain2 / (variance * (variance + gain2 * ff)) * fj.transpose() * fj;
  }
  precision.diagonal().array() += 12;
  return std::sqrt(2 / std::numbers::pi * std::max(g.dot(precision.ldlt().solve(g)), 0.0));
}

RowMatrix<float> draw_readings(const ReadingModel& model, const RowMatrix<float>& truth, std::uint64_t seed,
                               std::span<const float> largest) {
  RowMatrix<float> readings(truth.rows(), truth.cols());
  const auto size = static_cast<std::size_t>(model.size()), inputs = static_cast<std::size_t>(model.inputs);
  std::vector<float> noise(size), gains(inputs);
  for (Eigen::Index row = 0; row < truth.rows(); ++row) {
    const auto number = static_cast<std::uint64_t>(row);
    const std::span frames(truth.row(row).data(), size);
    std::ranges::fill(noise, 0.0f);
    std::ranges::fill(gains, 1.0f);
    add_noise(noise, deviation(model, frames, largest.empty() ? 0 : largest[number]), seed, number * size);
    add_noise(gains, model.gain, seed + 1, number * inputs);
    for (std::size_t k = 0; k < size; ++k)
      readings(row, static_cast<Eigen::Index>(k)) = gains[k % inputs] * frames[k] + noise[k];
    for (std::size_t m = 1; m < static_cast<std::size_t>(model.history); ++m)
      if (std::ranges::all_of(frames.subspan(m * inputs, inputs), [](float f) { return f == 0; }))
        readings.row(row).segment(static_cast<Eigen::Index>(m * inputs), model.inputs).setZero();
  }
  return readings;
}

}  // namespace tactel::nn
