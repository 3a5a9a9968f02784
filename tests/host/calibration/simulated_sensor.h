// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "host/calibration/sensor_calibration.h"

namespace tactel::host {

// Simulated sensors, whose gains, offsets, E and nu a calibration does not know. Their frames come from the sweeps on
// tables of their own layer, each press on its own patch; the calibration's come from a family of layers.
inline constexpr int tactels = 21, elements = 12;
inline constexpr double nominal_poisson = 0.45, nominal_young = 2;

inline const fem::SensorFamily& family() {
  static const fem::SensorFamily made({.poisson_low = 0.4, .poisson_high = 0.49}, false);
  return made;
}

inline SensorState nominal() { return {.log_young = std::log(nominal_young), .poisson = nominal_poisson}; }

/// The frames and forces of a press on a sensor of its own, E = 1.
struct Truth {
  Eigen::MatrixXd frame;
  Eigen::VectorXd P;
};

/// Presses on sensors of as many tactels are told apart by their names.
inline const Truth& truth(double poisson, const KnownPress& press) {
  using Layer = std::pair<double, int>;
  static std::map<Layer, fem::LayerModel> models;
  static std::map<std::pair<Layer, std::string>, Truth> known;
  fem::Scene own = press.scene;
  own.sensor.poisson = poisson;
  own.sensor.young = 1;
  const Layer layer{poisson, own.sensor.tactels};
  const auto found = known.find({layer, press.name});
  if (found != known.end()) return found->second;
  if (!models.contains(layer)) models.emplace(layer, fem::endless_layer(own.sensor));
  const fem::ContactSolution solution =
      fem::PatchSolver(models.at(layer), {.elements = elements, .tolerance = 1e-9}).solve(own);
  const auto steps = static_cast<Eigen::Index>(solution.steps.size());
  Truth t{Eigen::MatrixXd(steps, 2 * own.sensor.tactels), Eigen::VectorXd(steps)};
  for (Eigen::Index k = 0; k < steps; ++k) {
    const fem::ContactStep& step = solution.steps[static_cast<std::size_t>(k)];
    t.frame.row(k) << step.sigma_y.transpose(), step.tau_xy.transpose();
    t.P[k] = step.P;
  }
  return known[{layer, press.name}] = t;
}

/// The largest stress of presses on the nominal sensor, MPa.
inline double largest_stress(const std::vector<KnownPress>& presses) {
  double largest = 0;
  for (const KnownPress& press : presses)
    largest = std::max(largest, nominal_young * truth(nominal_poisson, press).frame.cwiseAbs().maxCoeff());
  return largest;
}

/// A sensor: what it is, and its readings of the presses with noise.
struct Simulated {
  double young, poisson;
  Eigen::VectorXd gain, offset;
  double noise;  ///< MPa
  std::vector<KnownPress> presses;
};

/// Gains and offsets spread by 20 % and 50 units, E by 30 %, nu is one of four; forces have 1 % of noise.
/// `time_constant` of amplifiers in s.
inline Simulated simulate_sensor(unsigned seed, std::vector<KnownPress> presses, double noise,
                                 double time_constant = std::numeric_limits<double>::infinity()) {
  constexpr double poissons[] = {0.43, 0.447, 0.46, 0.475};
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::Index channels = 2 * presses.front().scene.sensor.tactels;
  Simulated s{nominal_young * std::exp(0.3 * normal(random)),
              poissons[seed % 4],
              Eigen::VectorXd(channels),
              Eigen::VectorXd(channels),
              noise,
              std::move(presses)};
  for (Eigen::Index c = 0; c < channels; ++c)
    s.gain[c] = 0.001 * (1 + 0.2 * normal(random)), s.offset[c] = 2048 + 50 * normal(random);
  for (KnownPress& press : s.presses) {
    const Truth& t = truth(s.poisson, press);
    press.readings = s.young * t.frame;
    if (std::isfinite(time_constant)) press.readings = amplifier_response(press.timing, time_constant) * press.readings;
    for (Eigen::Index c = 0; c < channels; ++c)
      for (double& x : press.readings.col(c)) x = (x + s.noise * normal(random)) / s.gain[c] + s.offset[c];
    press.P = s.young * t.P;
    for (double& P : press.P) P *= 1 + 0.01 * normal(random);
  }
  return s;
}

}  // namespace tactel::host
