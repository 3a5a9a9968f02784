// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

#include "host/calibration/sensor_calibration.h"
#include "host/live/sensor_profile.h"
#include "host/scenes/toml_table.h"

namespace tactel::host {

/// Contents of a file of recordings (docs/calibration.md: every key).
struct PressRecordings {
  std::vector<KnownPress> presses;
  CalibrationOptions options;
  /// [channels] standard deviation of single readings while the indenter rests, the device's units; NaN: not known
  Eigen::VectorXd noise{};
};

/// Reads the tables [fit] and [transducer]. Throws ConfigError.
CalibrationOptions read_fit(const TomlFile& file);

/// Returns the tables of all sensors among which a fit with these options seeks, made through the cache.
fem::SensorFamily calibration_family(const fem::Sensor& sensor, const CalibrationOptions& options);

/// Throws ConfigError for the table `name` of a file where its sensor is not that of the table `first`.
void require_same_sensor(const TomlFile& file, const std::string& name, const AnyScene& scene, const std::string& first,
                         const AnyScene& expected);

/// Reads such a file, its scenes and its recordings, by the format and the channels of the profile. Throws ConfigError
/// for a wrong file, or a time without frames, and hw::RecordingError for a damaged recording.
PressRecordings read_press_recordings(const std::filesystem::path& path, const SensorProfile& profile);

/// Calibrates their sensor, a line or a pad, from the numbers of its scenes.
SensorCalibration calibrate_sensor(const PressRecordings& recordings, int threads);

/// Returns the text with control characters as blanks, for a comment in a file.
std::string one_line(std::string text);

/// Returns the calibration of the profile's channels: gains and offsets that were found, and noise [channels] that is
/// known; the others as they were.
hw::Calibration merged_calibration(const SensorProfile& profile, const SensorCalibration& found,
                                   const Eigen::VectorXd& noise);

/// Returns the profile's text with another calibration, and `remarks` as comments before it.
std::string calibrated_profile(const SensorProfile& profile, const hw::Calibration& calibration,
                               const std::vector<std::string>& remarks);

}  // namespace tactel::host
