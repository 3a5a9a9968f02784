// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

#include "host/calibration/sensor_calibration.h"
#include "host/live/sensor_profile.h"

namespace tactel::host {

/// Contents of a file of recordings (docs/sensors.md: every key).
struct PressRecordings {
  std::vector<KnownPress> presses;
  CalibrationOptions options;
  double poisson_low = 0, poisson_high = 0;  ///< in which Poisson's ratio is sought
};

/// Reads such a file, its scenes and its recordings, by the format and the channels of the profile. Throws ConfigError
/// for a wrong file, or a time without frames, and hw::RecordingError for a damaged recording.
PressRecordings read_press_recordings(const std::filesystem::path& path, const SensorProfile& profile);

/// Returns the calibration of the profile's channels: gains and offsets that were found, the others as they were.
hw::Calibration merged_calibration(const SensorProfile& profile, const SensorCalibration& found);

/// Returns the profile's text with another calibration, and `remarks` as comments before it.
std::string calibrated_profile(const SensorProfile& profile, const hw::Calibration& calibration,
                               const std::vector<std::string>& remarks);

}  // namespace tactel::host
