// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace tactel::host {

/// When a press moves and when it is read, each [load steps], s since the first frame, at which nothing touches yet.
struct PressTiming {
  std::vector<double> begin{}, end{};      ///< of the motion to a load step; the stress is linear in time within it
  std::vector<double> time{};              ///< of the reading
  void validate(std::size_t steps) const;  ///< throws ValueError: begin, end and time must follow one another
};

/// Returns what charge amplifiers make of the stresses at load steps, [steps, steps]: readings = response * stresses.
/// The reading of a constant stress decays with time_constant, s above 0; infinite: no decay (hw/charge_amplifier.h).
Eigen::MatrixXd amplifier_response(const PressTiming& timing, double time_constant);

}  // namespace tactel::host
