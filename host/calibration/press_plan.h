// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <string>
#include <vector>

#include "host/calibration/sensor_calibration.h"

namespace tactel::host {

/// A press or drag that a plan may choose.
struct PressCandidate {
  std::string indenter;  ///< for people: "cylinder, radius 6"
  fem::Scene scene;      ///< nominal sensor, indenter, friction and load
  PressTiming timing{};  ///< asked for where readings decay
};

struct PlanOptions {
  int presses = 10;
  CalibrationOptions fit{};  ///< what the calibration will fit
  bool forces = true;        ///< P is measured
  Eigen::VectorXd noise{};   ///< [2 tactels] MPa, standard deviation of a reading; NaN: no transducer. Empty: of all
                             ///< transducers noise_of_largest
  double noise_of_largest = 0.01;  ///< over the largest stress of all candidates
  int threads = 2;
  void validate(std::size_t candidates) const;  ///< throws ValueError
};

/// Standard deviations to expect of a calibration; NaN: held fixed.
struct ExpectedDeviations {
  Eigen::VectorXd gain{};                                  ///< [2 tactels] relative; NaN: no transducer
  double number[sensor_numbers];                           ///< by PressNumber: of ln E, nu, mm, mm, mm, ln RC
  double normal_gain = 0, shear_gain = 0, worst_gain = 0;  ///< medians over the tactels, and the largest, relative
};

struct PressPlan {
  std::vector<std::size_t> chosen;  ///< candidates, in their order
  std::vector<double> P;            ///< [candidates] N/mm: the largest of each
  Eigen::VectorXd noise;            ///< [2 tactels] MPa, as it was taken
  ExpectedDeviations planned{};
  std::vector<std::string> lost{};  ///< sentences: what no plan can find, or only with others
};

/// Chooses the presses that tell most: D-optimal for gains and the fitted numbers of the sensor. The information is
/// J^T J of the fit at the nominal sensor; offsets, and the friction of each press where it is fitted, are eliminated.
/// The criterion is compound (A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, 2007):
///     log det(gains) / transducers + 4 log det(sensor's numbers, gains eliminated) / numbers.
/// One determinant of all would give the many gains nearly all of it. Ten presses are then as good as twenty random
/// ones for gains and nu; E has one error of the gauge a press. Presses are taken one by one, each that adds
/// most, and then exchanged for better ones as long as there are any (V. V. Fedorov, Theory of Optimal Experiments,
/// 1972). None is taken twice. Throws ValueError for fewer candidates than presses or sensors that disagree.
PressPlan plan_presses(const fem::SensorFamily& family, const std::vector<PressCandidate>& candidates,
                       const PlanOptions& options = {});

}  // namespace tactel::host
