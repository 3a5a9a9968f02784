// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <ostream>
#include <string>

#include "fem/scenes/sensor.h"

namespace tactel::fem {

inline constexpr Element all_elements[] = {Element::bbar, Element::q4, Element::q4i, Element::q8};

/// The paper's meshes: B, 41 x 11 nodes, and A, 123 x 33.
inline Sensor mesh_b(Element element = Element::bbar, double poisson = 0.45) {
  return {.poisson = poisson, .element = element};
}
inline Sensor mesh_a(Element element = Element::bbar, double poisson = 0.45) {
  Sensor sensor = mesh_b(element, poisson);
  sensor.columns = 123;
  sensor.rows = 33;
  return sensor;
}

/// For names of parameterised tests and for messages.
inline std::string describe(const Sensor& s) {
  return std::string(name(s.element)) + "_" + std::to_string(s.columns) + "x" + std::to_string(s.rows) + "_nu" +
         std::to_string(std::lround(s.poisson * 1e4)) + "_" + name(s.stress);
}

/// What a test prints when it fails.
inline void PrintTo(const Sensor& sensor, std::ostream* out) { *out << describe(sensor); }
inline void PrintTo(Element element, std::ostream* out) { *out << name(element); }
inline void PrintTo(StressRecovery recovery, std::ostream* out) { *out << name(recovery); }

}  // namespace tactel::fem
