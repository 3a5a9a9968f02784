#pragma once
#include <memory>
#include <string>

#include "host/sensor_profile.h"
#include "hw/frame_source.h"

namespace tactel::host {

/// A source, opened, and how to read it.
struct OpenSource {
  std::unique_ptr<hw::FrameSource> source;
  SensorProfile profile;
};

/// Opens what --source names: "usb:glove", "usb:VID:PID" with a profile, "replay:FILE",
/// "simulate:SCENE.toml?rate=1000". Empty paths: no such file. Throws ConfigError, hw::SourceError.
OpenSource open_source(const std::string& source, const std::string& profile, const std::string& calibration);

}  // namespace tactel::host
