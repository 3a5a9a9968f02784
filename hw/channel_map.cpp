// SPDX-License-Identifier: Apache-2.0
#include "hw/channel_map.h"

#include <algorithm>
#include <cmath>

#include "hw/profile_error.h"

namespace tactel::hw {
namespace {

void validate_channels(const std::string& key, const std::vector<int>& map, std::size_t channels) {
  for (const int channel : map) require_within(key, channel, -1, static_cast<long>(channels) - 1);
}

void validate_numbers(const std::string& key, const std::vector<double>& values, std::size_t channels) {
  require(values.size() == channels, key, "an array of " + std::to_string(values.size()),
          "one number, or " + std::to_string(channels) + ", one for each channel");
  for (const double value : values) require(std::isfinite(value), key, std::to_string(value), "finite");
}

}  // namespace

void ChannelMap::validate(std::size_t channels) const {
  require_within("channels.normal", static_cast<long>(normal.size()), 1, 128);
  require(shear.size() == normal.size(), "channels.shear", "an array of " + std::to_string(shear.size()),
          "as long as channels.normal, " + std::to_string(normal.size()));
  validate_channels("channels.normal", normal, channels);
  validate_channels("channels.shear", shear, channels);
  validate_numbers("calibration.offset", calibration.offset, channels);
  validate_numbers("calibration.gain", calibration.gain, channels);
  if (calibration.noise.empty()) return;
  validate_numbers("calibration.noise", calibration.noise, channels);
  for (const double noise : calibration.noise)
    require(noise >= 0, "calibration.noise", std::to_string(noise), "0 or above, in the device's units");
}

int ChannelMap::channel(std::size_t place) const {
  return place < tactels() ? normal[place] : shear[place - tactels()];
}

std::string ChannelMap::channel_text(std::size_t place) const {
  return "channel " + std::to_string(channel(place)) + (place < tactels() ? " (normal" : " (shear") +
         " stress of tactel " + std::to_string(place % tactels()) + ")";
}

double ChannelMap::touch() const {
  double most = 0;
  if (calibration.noise.empty()) return most;
  for (const int channel : normal) {
    if (channel < 0) continue;
    const auto c = static_cast<std::size_t>(channel);
    most = std::max(most, touch_deviations * calibration.noise[c] * std::abs(calibration.gain[c]));
  }
  return most;
}

void ChannelMap::apply(std::span<const double> values, std::span<float> frame) const {
  const auto stress = [&](int channel) {
    if (channel < 0) return 0.0f;
    const auto c = static_cast<std::size_t>(channel);
    return static_cast<float>((values[c] - calibration.offset[c]) * calibration.gain[c]);
  };
  std::ranges::transform(normal, frame.begin(), stress);
  std::ranges::transform(shear, frame.begin() + static_cast<long>(normal.size()), stress);
}

}  // namespace tactel::hw
