// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "host/live/sensor_profile.h"
#include "hw/frame_source.h"

namespace tactel::host {

/// An open source and its profile.
struct OpenSource {
  std::unique_ptr<hw::FrameSource> source;
  SensorProfile profile;
  std::string note{};  ///< note for the user: the chosen one of several devices; may be empty
  std::function<float(std::uint64_t frame)>
      true_slip_index{};  ///< of a simulation: S of its frame, NaN without contact
};

/// Opens the source of --source: "usb:glove", "usb:VID:PID" with a profile, both with "?serial=NUMBER&port=1-2"
/// for one of several, "serial:/dev/ttyACM0?baud=115200", "csv:FILE" and "csv:-" with a profile, "replay:FILE",
/// "simulate:SCENE.toml?rate=1000". An empty path means no file. Throws ConfigError, hw::SourceError.
OpenSource open_source(const std::string& source, const std::string& profile, const std::string& calibration);

using Files = std::span<const std::string>;
/// The same with several profiles, whose pads have their numbers one after the other in a line of csv:. `calibrations`:
/// none, one for the source, or one for each profile.
OpenSource open_source(const std::string& source, Files profiles, Files calibrations);

/// Reads strictly the text after the colon of --source: "path?key=value&key=value".
class SourceOptions {
 public:
  explicit SourceOptions(const std::string& text);
  const std::string& path() const { return path_; }
  /// Reads a finite number. Returns whether the key is there, and leaves `value` unchanged where it is not. Throws
  /// ConfigError for a text that is no number.
  bool read(const std::string& key, double& value);
  bool read(const std::string& key, int& value);
  /// Throws ConfigError for an empty text.
  void read(const std::string& key, std::string& value);
  /// Throws ConfigError for a key that was not read.
  void finish() const;

 private:
  template <class Number>
  bool read_number(const std::string& key, Number& value, const char* what);
  std::string path_;
  std::map<std::string, std::string> given_;
  std::map<std::string, bool> asked_;
};

}  // namespace tactel::host
