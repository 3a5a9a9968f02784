// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/rubber_layer.h>

#include <span>
#include <vector>

namespace tactel {
struct Pad;
}

namespace tactel::fem {

struct Sensor;

/// What the rubber of a sensor is made of, by its thickness and the Young's modulus of its surface.
struct Rubber {
  double poisson = 0;                 ///< of its surface
  std::vector<RubberLayer> layers{};  ///< from the base up; none: one
  int below = 0;                      ///< of these, below the tactels; 0: they lie at the base
  auto operator<=>(const Rubber&) const = default;
};

/// Returns what tables of a line or pad depend on; neighbours of one rubber are one layer.
Rubber rubber(const std::vector<RubberLayer>& layers, double thickness, double young, double poisson);
Rubber rubber(const Sensor& line);
Rubber rubber(const Pad& pad);

/// Returns how far the surface is above the first layers, over the sum of all.
double height_above(std::span<const RubberLayer> layers, int below);

/// Throws ValueError for layers that no tables serve, and for other numbers than theirs beside them.
void check_layers(const std::vector<RubberLayer>& layers, double thickness, double young, double poisson);

/// Returns how far shear of the upper layers is carried, over the sum of all: the longest length of a plate on a bed at
/// any interface; 0 without layers.
double shear_length(const std::vector<RubberLayer>& layers);

/// Returns the thickness of rubber as soft as the surface, over the sum of all: 0.1 or more, 1 without layers.
double soft_thickness(const std::vector<RubberLayer>& layers);

/// Returns the largest Poisson's ratio in the rubber of a sensor.
template <class Sensor>
double largest_poisson(const Sensor& sensor) {
  double largest = sensor.poisson;
  for (const RubberLayer& layer : sensor.layers) largest = layer.poisson > largest ? layer.poisson : largest;
  return largest;
}

}  // namespace tactel::fem
