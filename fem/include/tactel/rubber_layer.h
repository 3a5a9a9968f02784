// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <compare>
#include <vector>

namespace tactel {

/// One of the layers that a rubber is made of, bonded to those below and above.
struct RubberLayer {
  double thickness = 1.0;  ///< mm
  double young = 2.0;      ///< MPa
  double poisson = 0.45;   ///< 0 <= poisson <= 0.5
  auto operator<=>(const RubberLayer&) const = default;
};

/// Returns a sensor whose thickness, young and poisson are those of its layers where they were left out, as files and
/// Python make it.
template <class Sensor>
Sensor with_layers(Sensor sensor) {
  if (sensor.layers.empty()) return sensor;
  double thickness = 0;
  for (const RubberLayer& layer : sensor.layers) thickness += layer.thickness;
  const auto fill = [](double& own, double usual, double given) { own = own == usual ? given : own; };
  fill(sensor.thickness, Sensor().thickness, thickness);
  fill(sensor.young, Sensor().young, sensor.layers.back().young);
  fill(sensor.poisson, Sensor().poisson, sensor.layers.back().poisson);
  return sensor;
}

}  // namespace tactel
