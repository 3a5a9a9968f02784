// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hw/channel_map.h"
#include "hw/usb_source.h"
#include "hw/wire_format.h"
#include "nn/infer/pad_moments.h"

namespace tactel::host {

/// Tactels of a pad, x fastest.
struct PadLayout {
  std::array<int, 2> tactels{};       ///< along x and y
  std::array<double, 2> pitch{0, 0};  ///< mm, from tactel to tactel; 0: not told
  std::size_t count() const { return static_cast<std::size_t>(tactels[0]) * static_cast<std::size_t>(tactels[1]); }
};

/// Contents of a profile file (docs/profiles.md: every key): the USB device, the format of its bytes, and the
/// channels of the stresses of the tactels.
struct SensorProfile {
  std::string text;  ///< the file, for recordings
  std::string name;
  std::string kind;  ///< of the format
  hw::UsbDevice usb;
  std::function<std::unique_ptr<const hw::WireFormat>()> format;
  hw::ChannelMap map;
  std::vector<PadLayout> pads{};  ///< whose tactels follow each other in `map`; none: a line
};

/// Reads a profile strictly, or takes the built-in one of that name: "glove", "uskin-4x4", "uskin-4x6". Throws
/// ConfigError.
SensorProfile read_profile(const std::filesystem::path& path);
/// Reads a profile from a text; errors name `source`.
SensorProfile parse_profile(const std::string& text, const std::string& source);
/// Returns the built-in profile of a USB device: "glove". Throws ConfigError.
SensorProfile built_in_profile(const std::string& name);
/// Returns the profile of lines of numbers that have the channels of one pad after those of the other. Throws
/// ConfigError for what is not a pad in lines of numbers, or differs in pitch or axes from the first.
SensorProfile joined_profile(const std::vector<SensorProfile>& profiles);
/// Returns the shape of a pad of the profile, or of its line, for its moments.
infer::PadShape shape_of(const SensorProfile& profile, std::size_t pad);
/// Returns the tables [pad] and [channels] of a profile.
std::string channels_text(const hw::ChannelMap& map, const std::vector<PadLayout>& pads);

/// Replaces the calibration of a profile by that of a calibration file, a single table [calibration]. Throws
/// ConfigError.
void read_calibration(const std::filesystem::path& path, SensorProfile& profile);
/// Returns the text of a calibration file.
std::string calibration_text(const hw::Calibration& calibration);

}  // namespace tactel::host
