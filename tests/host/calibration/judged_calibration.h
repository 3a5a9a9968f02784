// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "host/calibration/sensor_calibration.h"

namespace tactel::host {

/// The texts of the faults, or of those of a kind.
inline std::vector<std::string> texts(const SensorCalibration& c, std::optional<CalibrationFault::Kind> kind = {}) {
  std::vector<std::string> all;
  for (const CalibrationFault& fault : c.faults)
    if (!kind || fault.kind == *kind) all.push_back(fault.text);
  return all;
}

inline bool within(const Fitted& found, double value, double deviations = 2) {
  return std::abs(found.value - value) <= deviations * found.deviation;
}

/// How many gains are within so many of their deviations.
inline int gains_within(const SensorCalibration& c, const Eigen::VectorXd& gain, double deviations = 2) {
  int count = 0;
  for (Eigen::Index i = 0; i < gain.size(); ++i)
    count += within(c.gain[static_cast<std::size_t>(i)], gain[i], deviations);
  return count;
}

}  // namespace tactel::host
