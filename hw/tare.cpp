// SPDX-License-Identifier: Apache-2.0
#include "hw/tare.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactel::hw {
namespace {

constexpr double allowed_drift = 6;  // standard deviations of the noise
constexpr double allowed_steps = 2;  // smallest steps of the readings: the last bit of a converter may change

}  // namespace

void Tare::Channel::add(double value, std::size_t part) {
  if (!std::isfinite(value)) return;
  parts[part].sum += value;
  ++parts[part].readings;
  const double step = readings > 0 ? std::abs(value - last) : 0.0;
  steps += step;
  if (step > 0) smallest_step = smallest_step > 0 ? std::min(smallest_step, step) : step;
  last = value;
  ++readings;
}

/// Two parts become one.
void Tare::Channel::halve() {
  for (std::size_t i = 0; i < most_parts; ++i) {
    const bool filled = 2 * i < most_parts;
    parts[i] = filled ? Part{parts[2 * i].sum + parts[2 * i + 1].sum, parts[2 * i].readings + parts[2 * i + 1].readings}
                      : Part{};
  }
}

void Tare::add(std::span<const double> values) {
  if (frames_ == most_parts * frames_a_part_) {
    for (Channel& channel : channels_) channel.halve();
    frames_a_part_ *= 2;
  }
  const std::size_t part = frames_ / frames_a_part_;
  for (std::size_t i = 0; i < channels_.size(); ++i) channels_[i].add(values[i], part);
  ++frames_;
}

std::vector<double> Tare::offset() const {
  std::vector<double> means;
  for (std::size_t i = 0; i < channels_.size(); ++i) means.push_back(channel(i).mean);
  return means;
}

std::vector<double> Tare::noise() const {
  std::vector<double> all;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const ChannelRest rest = channel(i);
    all.push_back(std::max(rest.noise, rest.step / 2));
  }
  return all;
}

// White noise of standard deviation s makes steps of 2 s / sqrt(pi) on average between neighbours. The mean over n
// readings scatters by s / sqrt(n): parts of fewer than four readings are allowed more.
ChannelRest Tare::channel(std::size_t i) const {
  const Channel& channel = channels_[i];
  ChannelRest rest{.readings = channel.readings};
  if (channel.readings == 0) return rest;
  const auto steps = static_cast<double>(std::max<std::size_t>(channel.readings - 1, 1));
  rest.noise = channel.steps / steps * std::sqrt(std::numbers::pi) / 2;
  const std::size_t full = std::ranges::max(channel.parts, {}, &Part::readings).readings;
  const double few = 2 / std::sqrt(static_cast<double>(full));
  rest.step = channel.smallest_step;
  rest.allowed = allowed_drift * std::max(1.0, few) * rest.noise + allowed_steps * channel.smallest_step;
  double sum = 0;
  bool first = true;
  for (const Part& part : channel.parts) {
    sum += part.sum;
    if (2 * part.readings < full || part.readings == 0) continue;  // a part that has only begun
    rest.lowest = first ? part.mean() : std::min(rest.lowest, part.mean());
    rest.highest = first ? part.mean() : std::max(rest.highest, part.mean());
    first = false;
  }
  rest.mean = sum / static_cast<double>(channel.readings);
  return rest;
}

}  // namespace tactel::hw
