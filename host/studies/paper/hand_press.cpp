// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/hand_press.h"

#include <algorithm>
#include <cmath>

#include "nn/philox.h"

namespace tactel::host {

std::uint32_t Record::samples() const { return static_cast<std::uint32_t>(std::lround(seconds * rate)); }

double HandPress::load(double t) const {
  const double rising = (t - start) / rise, falling = (start + rise + hold + release - t) / release;
  return std::clamp(std::min(rising, falling), 0.0, 1.0);
}

HandPress hand_press(std::uint64_t seed, std::uint32_t number) {
  const auto words = nn::random_words(seed, nn::RandomStream::contact, number);
  const auto between = [](std::uint32_t word, double low, double high) { return low + (high - low) * word * 0x1p-32; };
  return {between(words[0], 2, 5), between(words[1], 0.5, 1.5), between(words[2], 1, 2), between(words[3], 0.3, 0.7)};
}

std::vector<float> pressed_record(const fem::ContactSolution& solution, const HandPress& press, const Record& record) {
  const auto steps = static_cast<Eigen::Index>(solution.steps.size());
  const Eigen::Index tactels = solution.tactel_x.size();
  Eigen::MatrixXd knots = Eigen::MatrixXd::Zero(2 * tactels, steps + 1);  // [channels, load steps from no load on] MPa
  for (Eigen::Index k = 0; k < steps; ++k) knots.col(k + 1) << solution.steps[k].sigma_y, solution.steps[k].tau_xy;
  std::vector<float> stress(record.samples() * knots.rows());
  for (std::uint32_t sample = 0; sample < record.samples(); ++sample) {
    const double at = press.load(sample / record.rate) * static_cast<double>(steps);
    const auto from = std::min(static_cast<Eigen::Index>(at), steps - 1);
    const double share = at - static_cast<double>(from);
    Eigen::Map<Eigen::VectorXf>(&stress[sample * knots.rows()], knots.rows()) =
        ((1 - share) * knots.col(from) + share * knots.col(from + 1)).cast<float>();
  }
  return stress;
}

std::size_t highest_normal_sample(std::span<const float> record, std::size_t channels) {
  std::size_t highest = 0;
  float most = record[0];
  for (std::size_t sample = 0; sample < record.size() / channels; ++sample) {
    const float compression = std::ranges::min(record.subspan(sample * channels, channels / 2));
    if (compression < most) highest = sample, most = compression;
  }
  return highest;
}

}  // namespace tactel::host
