// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "fem/gap/solution_difference.h"
#include "fem/scenes/scene.h"

namespace tactel::tests {

/// Every kind of indenter, at sizes that touch from one node to all of them.
inline std::vector<fem::Shape> all_shapes() {
  using namespace fem;
  return {Flat{},
          Flat{4.0},
          Wedge{120},
          Parabola{10},
          Cylinder{30},
          Exponential{0.1, 0.5},
          Trapezoid{2, 0.5},
          RoundedFlat{2, 10},
          Taylor{{1, 3}, 10.0, {}},
          Profile{{-6, -3, -1, 0, 1, 3, 6}, {0.9, 0.2, 0.02, 0, 0.02, 0.2, 0.9}, 0.0, ""}};
}

inline fem::Sensor paper_mesh(char which) {
  return {.columns = which == 'A' ? 123 : 41, .rows = which == 'A' ? 33 : 11};
}

/// Press in two steps, drag, go back through zero, and forth again.
inline fem::Load reversal() { return {.indentation_steps = 2, .tangential = {0.05, 0.1, 0.2, 0.1, -0.1, -0.05}}; }

/// Random shapes, places, friction, depths and paths on one sensor.
inline std::vector<fem::Scene> random_scenes(const fem::Sensor& sensor, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto shapes = all_shapes();
  std::vector<fem::Scene> scenes(count);
  for (fem::Scene& scene : scenes) {
    scene.sensor = sensor;
    scene.sensor.young = std::exp(uniform(std::log(0.1), std::log(10.0)));
    scene.indenter.shape = shapes[random() % shapes.size()];
    scene.indenter.position = uniform(-4, 4);
    scene.friction = uniform(0.05, 1.5);
    scene.load.indentation = {uniform(0.02, 0.3)};
    scene.load.indentation_steps = 1 + static_cast<int>(random() % 3);
    for (int k = static_cast<int>(random() % 7); k > 0; --k) scene.load.tangential.push_back(uniform(-0.3, 0.3));
  }
  return scenes;
}

/// The same with forces for goals, P, or P and Q by an angle up to 9/10 of the friction angle.
inline std::vector<fem::Scene> random_force_scenes(const fem::Sensor& sensor, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  auto scenes = random_scenes(sensor, count, seed + 1);
  for (fem::Scene& scene : scenes) {
    scene.load.indentation.clear();
    scene.load.normal_force = {scene.sensor.young * std::exp(uniform(std::log(0.005), std::log(0.5)))};
    if (random() % 2) continue;
    scene.load.tangential.clear();
    scene.load.angle = uniform(-0.9, 0.9) * std::atan(scene.friction) * 180 / std::numbers::pi;
  }
  return scenes;
}

}  // namespace tactel::tests
