// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "host/calibration/sensor_calibration.h"
#include "host/figures/page.h"

namespace tactel::host {

/// Returns the sizes (rms) of the residuals of a calibration, by press over the noise, and by tactel in kPa.
Figure residual_figure(const SensorCalibration& found, const std::vector<KnownPress>& presses);

/// Returns the page of a calibration: the sensor's numbers, gains with two deviations, residuals, what was held fixed
/// and what is wrong. `recordings` and `profile` are names of files.
Page calibration_page(const SensorCalibration& found, const std::vector<KnownPress>& presses,
                      const std::string& recordings, const std::string& profile);

}  // namespace tactel::host
