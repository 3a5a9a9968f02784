// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "hw/channel_map.h"
#include "hw/usb_device.h"
#include "hw/wire_format.h"

namespace tactel::host {

/// Contents of a profile file (docs/sensors.md: every key): the USB device, the format of its bytes, and the
/// channels of the stresses of the tactels.
struct SensorProfile {
  std::string text;  ///< the file, for recordings
  std::string name;
  std::string kind;  ///< of the format
  hw::UsbDevice usb;
  std::function<std::unique_ptr<const hw::WireFormat>()> format;
  hw::ChannelMap map;
};

/// Reads a profile strictly. Throws ConfigError.
SensorProfile read_profile(const std::filesystem::path& path);
/// Reads a profile from a text; errors name `source`.
SensorProfile parse_profile(const std::string& text, const std::string& source);
/// Returns a built-in profile: "glove". Throws ConfigError.
SensorProfile built_in_profile(const std::string& name);

/// Replaces the calibration of a profile by that of a calibration file, a single table [calibration]. Throws
/// ConfigError.
void read_calibration(const std::filesystem::path& path, SensorProfile& profile);
/// Returns the text of a calibration file.
std::string calibration_text(const hw::Calibration& calibration);

}  // namespace tactel::host
