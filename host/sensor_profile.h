#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "hw/channel_map.h"
#include "hw/usb_device.h"
#include "hw/wire_format.h"

namespace tactel::host {

/// What a profile file says of a sensor (docs/sensors.md: every key): how to open it, how to read its bytes, which
/// channel is which stress of which tactel.
struct SensorProfile {
  std::string text;  ///< the file, for recordings
  std::string name;
  hw::UsbDevice usb;
  std::function<std::unique_ptr<const hw::WireFormat>()> format;
  hw::ChannelMap map;
};

/// Reads a profile strictly. Throws ConfigError.
SensorProfile read_profile(const std::filesystem::path& path);
/// The same from a text; errors name `source`.
SensorProfile parse_profile(const std::string& text, const std::string& source);
/// One that comes with the program: "glove". Throws ConfigError.
SensorProfile built_in_profile(const std::string& name);

/// A calibration file, a table [calibration] alone, in the place of the profile's own. Throws ConfigError.
void read_calibration(const std::filesystem::path& path, SensorProfile& profile);
/// The text of such a file.
std::string calibration_text(const hw::Calibration& calibration);

}  // namespace tactel::host
