// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/scenes/scene.h"

namespace tactel::bench {

/// Mesh A (123 x 33) or B (41 x 11).
inline fem::Sensor mesh(char which) {
  fem::Sensor sensor;
  sensor.columns = which == 'A' ? 123 : 41;
  sensor.rows = which == 'A' ? 33 : 11;
  return sensor;
}

/// Radius 1 to 100 mm (log-uniform), friction 0.1 to 1.5; one step that presses, seven of drag.
inline std::vector<fem::Scene> random_parabolas(const fem::Sensor& sensor, std::size_t count) {
  std::mt19937_64 random(1998);
  std::uniform_real_distribution<double> log_radius(std::log(1.0), std::log(100.0)), friction(0.1, 1.5);
  fem::Scene scene;
  scene.sensor = sensor;
  scene.load.tangential_step = 0.05;
  scene.load.tangential_steps = 7;
  std::vector<fem::Scene> scenes(count, scene);
  for (fem::Scene& s : scenes) {
    s.indenter.shape = fem::Parabola{std::exp(log_radius(random))};
    s.friction = friction(random);
  }
  return scenes;
}

/// Largest difference of P and Q over P, and of S, between two answers of a step.
template <class Step>
double difference(double friction, const Step& found, const fem::ContactStep& expected) {
  const double force = (std::abs(found.P - expected.P) + std::abs(found.Q - expected.Q)) / expected.P;
  const double S = std::abs(found.Q / (friction * found.P) - expected.Q / (friction * expected.P));
  return std::max(force, S);
}

}  // namespace tactel::bench
