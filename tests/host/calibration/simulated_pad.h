// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_solver.h"
#include "tests/host/calibration/judged_calibration.h"

namespace tactel::host {

// Simulated pads, whose gains, offsets, E, nu and H a calibration does not know. Their frames come from as many cells
// as no calibration takes, on the true layer.

inline fem::PadScene& pad(KnownPress& press) { return std::get<fem::PadScene>(press.scene); }
inline const fem::PadScene& pad(const KnownPress& press) { return std::get<fem::PadScene>(press.scene); }

inline constexpr double nominal_thickness = 4, pad_young = 0.5;  ///< mm, MPa

inline SensorState nominal_pad() {
  return {.log_young = std::log(pad_young), .poisson = 0.46, .thickness = nominal_thickness};
}

/// Two spheres pressed and dragged beside 4 x 4 tactels, and a flat between them.
inline std::vector<KnownPress> pad_presses() {
  std::vector<KnownPress> all;
  const auto add = [&all](fem::PadShape shape, double x, double y, double depth) {
    KnownPress press;
    press.name = "press " + std::to_string(all.size() + 1);
    fem::PadScene scene;
    const SensorState nominal = nominal_pad();
    scene.sensor = {.thickness = nominal.thickness, .young = pad_young, .poisson = nominal.poisson};
    scene.indenter = {.shape = std::move(shape), .position = {x, y}};
    scene.friction = 0.8;
    scene.load.indentation = {depth};
    scene.load.indentation_steps = 2;
    const double side = all.size() % 2 ? -0.2 : 0.2;
    scene.load.drags = {{side, 0, 0}, {side, -side, 0}, {0, -side, 0}};
    press.scene = scene;
    all.push_back(press);
  };
  for (int k = 0; k < 16; ++k)
    add(fem::Sphere{k % 3 ? 6.0 : 10.0}, 4.7 * (k % 4 - 1.5) + 0.8, 4.7 * (k / 4 - 1.5) - 0.6, 0.6 + 0.1 * (k % 5));
  for (int k = 0; k < 4; ++k) add(fem::Punch{2.5, 0}, k % 2 ? 4.7 : -4.7, k < 2 ? 4.7 : -4.7, 0.3 + 0.05 * k);
  return all;
}

struct SimulatedPad {
  double young, poisson, thickness;
  Eigen::VectorXd gain, offset;
  double noise;  ///< MPa
  std::vector<KnownPress> presses;
};

/// What a calibration does not know of a pad.
struct PadAs {
  double noise = 0.005;  ///< of a reading over the largest stress
  double gauge = 0.01;   ///< one error of P a press, relative
  int cells = 40, drag_increments = 4;
};

/// Frame and forces of a press on a pad, E = 1.
inline fem::PadSolution true_press(const SimulatedPad& of, const KnownPress& press, const PadAs& as) {
  fem::PadScene scene = pad(press);
  scene.sensor.young = 1, scene.sensor.poisson = of.poisson, scene.sensor.thickness = of.thickness;
  const fem::PadOptions options{.cells = as.cells,
                                .tolerance = 1e-4,
                                .drag_increments = as.drag_increments,
                                .limit_increments = 0,
                                .ladder = false};
  return fem::PadSolver(fem::pad_layer(of.poisson), options).solve(scene);
}

/// Gains spread by 15 %, offsets by 50 units, E by 30 %, H by 5 %; nu from 0.43 to 0.495.
inline SimulatedPad simulate_pad(unsigned seed, std::vector<KnownPress> presses, const PadAs& as = {}) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.43, 0.495);
  const Eigen::Index channels = channels_of(presses.front().scene);
  SimulatedPad s{.young = pad_young * std::exp(0.3 * normal(random)),
                 .poisson = uniform(random),
                 .thickness = nominal_thickness * (1 + 0.05 * normal(random)),
                 .gain = Eigen::VectorXd(channels),
                 .offset = Eigen::VectorXd(channels),
                 .noise = 0,
                 .presses = std::move(presses)};
  for (Eigen::Index c = 0; c < channels; ++c)
    s.gain[c] = 1e-5 * (1 + 0.15 * normal(random)), s.offset[c] = 20000 + 50 * normal(random);
  for (KnownPress& press : s.presses) {
    const fem::PadSolution solution = true_press(s, press, as);
    press.readings.resize(static_cast<Eigen::Index>(solution.steps.size()), channels);
    press.P.resize(press.readings.rows());
    const double gauge = 1 + as.gauge * normal(random);
    for (Eigen::Index k = 0; k < press.P.size(); ++k) {
      const fem::PadStep& step = solution.steps[static_cast<std::size_t>(k)];
      press.readings.row(k) = s.young * step.stress.reshaped().head(channels);
      press.P[k] = s.young * step.P * gauge;
    }
    s.noise = std::max(s.noise, as.noise * press.readings.cwiseAbs().maxCoeff());
  }
  for (KnownPress& press : s.presses)
    for (Eigen::Index c = 0; c < channels; ++c)
      for (double& x : press.readings.col(c)) x = (x + s.noise * normal(random)) / s.gain[c] + s.offset[c];
  return s;
}

}  // namespace tactel::host
