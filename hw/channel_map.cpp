// SPDX-License-Identifier: Apache-2.0
#include "hw/channel_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "hw/format_parts.h"

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

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

/// Of stresses that are not nonsense in MPa, whatever the device's unit: readings of 32 bits must fit a float.
constexpr double least_gain = 1e-20, most_gain = 1e20, most_offset = 1e15, most_noise = 1e5;  // most_noise: MPa

}  // namespace

void ChannelMap::validate(std::size_t channels) const {
  require_within("channels.normal", static_cast<long>(normal.size()), 1, 128);
  const std::string x = shear_y.empty() ? "channels.shear" : "channels.shear_x";
  for (const auto& [key, axis] : {std::pair{x, &shear}, {"channels.shear_y", &shear_y}}) {
    require(axis->empty() || axis->size() == normal.size(), key, "an array of " + std::to_string(axis->size()),
            "as long as channels.normal, " + std::to_string(normal.size()));
    validate_channels(key, *axis, channels);
  }
  validate_channels("channels.normal", normal, channels);
  validate_numbers("calibration.offset", calibration.offset, channels);
  validate_numbers("calibration.gain", calibration.gain, channels);
  if (!calibration.noise.empty()) validate_numbers("calibration.noise", calibration.noise, channels);
  for (const double noise : calibration.noise)
    require(noise >= 0, "calibration.noise", text_of(noise), "0 or above, in the device's units");
  require(calibration.moved >= 0 && calibration.moved < 0.5, "calibration.moved", text_of(calibration.moved),
          "above 0 and below 0.5, as tactel tare --hold writes it");
  require(calibration.slid >= 0 && calibration.slid < 1, "calibration.slid", text_of(calibration.slid),
          "above 0 and below 1, as tactel tare --hold --network writes it");
  for (std::size_t place = 0; place < places(); ++place) {
    if (channel(place) < 0) continue;
    const auto c = static_cast<std::size_t>(channel(place));
    const std::string whose = " for " + channel_text(place);
    const double gain = calibration.gain[c], offset = calibration.offset[c];
    require(std::abs(gain) >= least_gain && std::abs(gain) <= most_gain, "calibration.gain", text_of(gain),
            "MPa by the device's unit" + whose + ", " + text_of(least_gain) + " to " + text_of(most_gain) +
                " or minus that; a tactel without a channel has -1 in [channels]");
    require(std::abs(offset) <= most_offset, "calibration.offset", text_of(offset),
            "a reading at rest" + whose + ", at most " + text_of(most_offset));
    if (calibration.noise.empty()) continue;
    const double noise = calibration.noise[c];
    require(noise * std::abs(gain) <= most_noise, "calibration.noise", text_of(noise),
            "a standard deviation at rest" + whose + ", at most " + text_of(most_noise) + " MPa by its gain, " +
                text_of(most_noise / std::abs(gain)));
  }
}

int ChannelMap::channel(std::size_t place) const {
  for (const std::vector<int>* axis : {&normal, &shear, &shear_y}) {
    if (place < axis->size()) return (*axis)[place];
    place -= axis->size();
  }
  return -1;
}

std::string ChannelMap::channel_text(std::size_t place) const {
  const char* axis = place < tactels()       ? " (normal stress"
                     : shear_y.empty()       ? " (shear stress"
                     : place < 2 * tactels() ? " (shear stress along x"
                                             : " (shear stress along y";
  return "channel " + std::to_string(channel(place)) + axis + " of tactel " + std::to_string(place % tactels()) + ")";
}

double ChannelMap::touch(std::size_t first, std::size_t count) const {
  double most = 0;
  if (calibration.noise.empty()) return most;
  for (const int channel : std::span(normal).subspan(first, count)) {
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
  auto to = frame.begin();
  for (const std::vector<int>* axis : {&normal, &shear, &shear_y}) to = std::ranges::transform(*axis, to, stress).out;
}

}  // namespace tactel::hw
