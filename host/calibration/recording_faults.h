// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "host/calibration/press_readings.h"

namespace tactel::host {

/// Faults of recordings. Each function adds what it finds to `faults` and leaves that out of the fit. frame: [rows,
/// channels] MPa, of the model.

/// Channels that never change, and readings at the ends of the converter's range.
void find_constant_and_saturated(PressReadings& readings, const CalibrationOptions& options,
                                 std::vector<CalibrationFault>& faults);
/// Pairs of channels of which each reads as the other should.
void find_swapped(PressReadings& readings, const Eigen::MatrixXd& frame, std::vector<CalibrationFault>& faults);
/// Channels of which the gain does not differ from none, where others would have shown a signal.
void find_dead(PressReadings& readings, const Eigen::MatrixXd& frame, std::vector<CalibrationFault>& faults);
/// The press with another indenter, depth or place than it says: its residuals are far beyond those of the others.
/// Returns whether there is one.
bool find_wrong_press(PressReadings& readings, const Eigen::MatrixXd& frame, std::vector<CalibrationFault>& faults);
/// A model that does not fit: `better` are sentences on what fits better; without any, residuals beyond the noise.
void find_misfit(const PressReadings& readings, const Eigen::MatrixXd& frame, const CalibrationOptions& options,
                 const std::vector<std::string>& better, std::vector<CalibrationFault>& faults);
/// A wrong indenter, friction or place of all presses: it bends the model to readings that no gain explains.
void find_wrong_indenter(const PressReadings& readings, const Eigen::MatrixXd& frame, const CalibrationOptions& options,
                         std::vector<CalibrationFault>& faults);

}  // namespace tactel::host
