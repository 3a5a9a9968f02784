// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/calibration/press_model.h"
#include "host/calibration/press_timing.h"

namespace tactel::host {

/// The readings of one press or drag of a known indenter.
struct KnownPress {
  std::string name;          ///< for messages
  AnyScene scene;            ///< indenter, friction, load by depth or force, nominal sensor
  Eigen::MatrixXd readings;  ///< [steps, channels] in the device's units, in the order of a frame; NaN: no reading
  Eigen::VectorXd P;         ///< [steps] N/mm, of a pad N, measured; NaN or empty: not measured
  PressTiming timing{};      ///< asked for where readings decay
};

struct CalibrationOptions {
  bool fit_poisson = true, fit_thickness = false, fit_shift = false, fit_time_constant = false;
  /// s, of the charge amplifiers of all transducers; infinite: constant stresses read as constants
  double time_constant = std::numeric_limits<double>::infinity();
  double friction_deviation = 0;  ///< of each press's friction about its scene's, relative; 0: it is known
  double force_noise = 0.01;      ///< standard deviation of the gauge's error, one for all forces of a press, relative
  Eigen::VectorXd noise{};        ///< [channels] least standard deviation of readings; empty: that of the residuals
  /// [channels] noise of readings while the indenter rests, by which a wrong indenter is found; empty: `noise`
  Eigen::VectorXd rest_noise{};
  double lowest_reading = -std::numeric_limits<double>::infinity(),
         highest_reading = std::numeric_limits<double>::infinity();  ///< at or beyond: the converter is saturated
  int most_iterations = 30;
  int elements = 24;      ///< of the patch of each press; on a pad half as many cells a side
  int threads = 1;        ///< that solve presses
  void validate() const;  ///< throws ValueError
};

/// Correlation from which two numbers are not told apart.
inline constexpr double degenerate = 0.98;

/// What is wrong with the recordings: named. Channels and presses are left out of the fit.
struct CalibrationFault {
  enum class Kind { dead_channel, swapped_channels, saturated, wrong_press, wrong_indenter, model_misfit };
  Kind kind;
  std::string text;                       ///< a sentence
  Eigen::Index channel = -1, other = -1;  ///< place in a frame; the other of a swapped pair
  Eigen::Index press = -1;
};
/// By kind, in JSON.
inline constexpr const char* fault_names[] = {"dead_channel", "swapped_channels", "saturated",
                                              "wrong_press",  "wrong_indenter",   "model_misfit"};

/// A fitted number and its standard deviation; 0: held fixed.
struct Fitted {
  double value = 0, deviation = 0;
};

struct SensorCalibration {
  bool converged = false;
  int iterations = 0;
  bool pad = false;
  Eigen::Index tactels = 0;
  Fitted young, poisson, thickness, shift, shift_y;  ///< MPa, none, mm, mm, mm
  Fitted time_constant;                              ///< s; infinite: no decay
  std::vector<Fitted> friction;                      ///< [presses]
  std::vector<Fitted> gain, offset;       ///< [channels] MPa by the device's unit; the device's unit. NaN: left out
  std::vector<double> noise;              ///< [channels] standard deviation of the residuals, the device's unit
  Eigen::MatrixXd correlation;            ///< [fitted, fitted]
  std::vector<std::string> fitted, held;  ///< names of numbers; sentences: what is held fixed, and why
  std::vector<CalibrationFault> faults;
  std::vector<Eigen::MatrixXd> residuals;  ///< [presses] [steps, channels] reading less model over noise; NaN: left out
};
/// By PressNumber.
inline constexpr Fitted SensorCalibration::*found_numbers[sensor_numbers] = {
    &SensorCalibration::young, &SensorCalibration::poisson, &SensorCalibration::thickness,
    &SensorCalibration::shift, &SensorCalibration::shift_y, &SensorCalibration::time_constant};

/// The numbers of the sensor that a fit with these options seeks; E where presses tell it.
std::vector<PressNumber> fitted_numbers(const CalibrationOptions& options, bool young_told, bool pads);
/// The numbers of the sensor of a calibration: a line has no shift along y, stresses may not decay.
std::vector<PressNumber> numbers_of(const SensorCalibration& found);

/// Names of the stresses of a tactel, in the order of a frame: two of a line, one or three of a pad.
std::vector<std::string> stress_names(Eigen::Index channels, Eigen::Index tactels);
/// Returns the name of a transducer, by its place in a frame.
std::string transducer_name(Eigen::Index channel, Eigen::Index channels, Eigen::Index tactels);

/// Fits gains and offsets of all transducers, and the rubber, to readings of known presses: reading = offset + stress /
/// gain. Given the rubber this is linear and solved exactly (variable projection); the rubber's numbers follow by
/// Levenberg-Marquardt on the derivatives of a PressModel, with Huber's weights against outliers. E and gains are told
/// apart by measured forces alone: without any, E is held. Poisson's ratio and thickness are nearly degenerate; the
/// thickness is held unless asked for. On request it finds the time constant of the amplifiers, and the friction of
/// each press about that of its scene. Throws ValueError for sizes that disagree, presses of lines and pads together,
/// and recordings that determine nothing.
SensorCalibration calibrate_sensor(const fem::SensorFamily& family, const std::vector<KnownPress>& presses,
                                   const SensorState& start, const CalibrationOptions& options = {});
/// The same of presses on a pad, with any Poisson's ratio.
SensorCalibration calibrate_pad(const std::vector<KnownPress>& presses, const SensorState& start,
                                const CalibrationOptions& options = {});

}  // namespace tactel::host
