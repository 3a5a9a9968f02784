// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <tuple>

#include "tests/host/calibration/judged_calibration.h"

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

inline fem::Scene& line(KnownPress& press) { return std::get<fem::Scene>(press.scene); }

/// How a sensor is, and what its calibration does not know of it.
struct SimulatedAs {
  double thickness = 1.5;    ///< mm
  double radius = 1;         ///< of the cylinders of the presses, over what their scenes say
  double press_force = 0;    ///< standard deviation of one error of P a press, relative: a gauge's
  double step_force = 0.01;  ///< the same of an error a load step
  int truth = 2 * elements;  ///< elements of the patches on which the frames are solved
  double time_constant = std::numeric_limits<double>::infinity();  ///< s, of amplifiers
};

/// The frames and forces of a press on a sensor of its own, E = 1.
struct Truth {
  Eigen::MatrixXd frame;
  Eigen::VectorXd P;
};

/// Presses on sensors of as many tactels are told apart by their names.
inline const Truth& truth(double poisson, const KnownPress& press, const SimulatedAs& as = {}) {
  using Layer = std::tuple<double, double, int>;
  static std::map<Layer, fem::LayerModel> models;
  static std::map<std::tuple<Layer, double, int, std::string>, Truth> known;
  fem::Scene own = std::get<fem::Scene>(press.scene);
  own.sensor.poisson = poisson;
  own.sensor.young = 1;
  own.sensor.thickness = as.thickness;
  if (auto* cylinder = std::get_if<fem::Cylinder>(&own.indenter.shape)) cylinder->radius *= as.radius;
  const Layer layer{poisson, as.thickness, own.sensor.tactels};
  const std::tuple key{layer, as.radius, as.truth, press.name};
  const auto found = known.find(key);
  if (found != known.end()) return found->second;
  if (!models.contains(layer)) models.emplace(layer, fem::endless_layer(own.sensor));
  const fem::ContactSolution solution =
      fem::PatchSolver(models.at(layer), {.elements = as.truth, .tolerance = 1e-9}).solve(own);
  const auto steps = static_cast<Eigen::Index>(solution.steps.size());
  Truth t{Eigen::MatrixXd(steps, 2 * own.sensor.tactels), Eigen::VectorXd(steps)};
  for (Eigen::Index k = 0; k < steps; ++k) {
    const fem::ContactStep& step = solution.steps[static_cast<std::size_t>(k)];
    t.frame.row(k) << step.sigma_y.transpose(), step.tau_xy.transpose();
    t.P[k] = step.P;
  }
  return known[key] = t;
}

/// The largest stress of presses on the nominal sensor, MPa.
inline double largest_stress(const std::vector<KnownPress>& presses) {
  double largest = 0;
  for (const KnownPress& press : presses)
    largest = std::max(largest, nominal_young * truth(nominal_poisson, press).frame.cwiseAbs().maxCoeff());
  return largest;
}

/// Twenty presses and drags of two cylinders along the array.
inline std::vector<KnownPress> presses() {
  std::vector<KnownPress> all;
  for (int k = 0; k < 20; ++k) {
    KnownPress press;
    press.name = "press " + std::to_string(k + 1);
    line(press).sensor.poisson = nominal_poisson;
    line(press).sensor.young = nominal_young;
    line(press).indenter = {fem::Cylinder{k % 2 ? 6.0 : 15.0}, -9.0 + 18.0 * k / 19};
    line(press).friction = 0.6;
    line(press).load.indentation = {0.1 + 0.02 * (k % 4)};
    line(press).load.indentation_steps = 2;
    line(press).load.tangential = {0.02, 0.05, 0.08};
    all.push_back(press);
  }
  return all;
}

/// A sensor: what it is, and its readings of the presses with noise.
struct Simulated {
  double young, poisson;
  Eigen::VectorXd gain, offset;
  double noise;  ///< MPa
  std::vector<KnownPress> presses;
};

/// Gains and offsets spread by 20 % and 50 units, E by 30 %, nu is one of four. `noise`: MPa.
inline Simulated simulate_sensor(unsigned seed, std::vector<KnownPress> presses, double noise,
                                 const SimulatedAs& as = {}) {
  constexpr double poissons[] = {0.43, 0.447, 0.46, 0.475};
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::Index channels = channels_of(presses.front().scene);
  Simulated s{nominal_young * std::exp(0.3 * normal(random)),
              poissons[seed % 4],
              Eigen::VectorXd(channels),
              Eigen::VectorXd(channels),
              noise,
              std::move(presses)};
  for (Eigen::Index c = 0; c < channels; ++c)
    s.gain[c] = 0.001 * (1 + 0.2 * normal(random)), s.offset[c] = 2048 + 50 * normal(random);
  for (KnownPress& press : s.presses) {
    const Truth& t = truth(s.poisson, press, as);
    press.readings = s.young * t.frame;
    if (std::isfinite(as.time_constant))
      press.readings = amplifier_response(press.timing, as.time_constant) * press.readings;
    for (Eigen::Index c = 0; c < channels; ++c)
      for (double& x : press.readings.col(c)) x = (x + s.noise * normal(random)) / s.gain[c] + s.offset[c];
    press.P = s.young * t.P;
    for (double& P : press.P) P *= 1 + as.step_force * normal(random);
    if (as.press_force > 0) press.P *= 1 + as.press_force * normal(random);
  }
  return s;
}

}  // namespace tactel::host
