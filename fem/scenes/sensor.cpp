// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/sensor.h"

#include <algorithm>
#include <cmath>

#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "fem/scenes/rubber.h"

namespace tactel::fem {
namespace {

void check_sensor(bool good, const char* member, double value, const char* allowed) {
  if (!good) throw ValueError(std::string("sensor.") + member, number_text(value), allowed);
}

/// For quantities whose only law is to be positive; infinity and NaN are not.
bool positive(double value) { return std::isfinite(value) && value > 0; }

bool within(double value, double least, double most) { return value >= least && value <= most; }

}  // namespace

void validate(const Sensor& sensor) {
  check_layers(sensor.layers, sensor.thickness, sensor.young, sensor.poisson);
  // The bounds on sizes are far outside what a tactile skin can be; they keep every later product finite.
  check_sensor(within(sensor.length, 1e-6, 1e6), "length", sensor.length, "a length in mm, between 1e-6 and 1e6");
  check_sensor(within(sensor.thickness, 1e-6, 1e6), "thickness", sensor.thickness,
               "a thickness in mm, between 1e-6 and 1e6");
  check_sensor(positive(sensor.young), "young", sensor.young, "a Young's modulus in MPa, finite and above 0");
  check_sensor(within(sensor.poisson, 0, 0.5), "poisson", sensor.poisson, "a Poisson's ratio, 0 <= poisson <= 0.5");
  check_sensor(within(sensor.columns, 3, most_columns), "columns", sensor.columns,
               "a number of mesh nodes along x, 3 to 2001");
  check_sensor(within(sensor.rows, 2, most_rows), "rows", sensor.rows,
               "a number of mesh nodes through the thickness, 2 to 1001");
  check_sensor(sensor.rows > static_cast<int>(sensor.layers.size()), "rows", sensor.rows,
               "more mesh nodes through the thickness than sensor.layers");
  check_sensor(within(sensor.grading, 0.01, 100), "grading", sensor.grading,
               "the bottom row's height over the top row's, 0.01 to 100 (1 is uniform)");
  check_sensor(within(sensor.tactels, 2, most_tactels), "tactels", sensor.tactels, "a number of tactels, 2 to 10000");
  check_sensor(within(sensor.tactel_width, 0, sensor.length / sensor.tactels), "tactel_width", sensor.tactel_width,
               "a width in mm, 0 (a point) to the sensor's length over the number of tactels");
  // Transducers side by side, on the rubber; a hair's breadth for what decimal numbers lose in binary.
  const double hair = 1e-12 * sensor.length;
  check_sensor(
      within(sensor.span(), sensor.tactel_width * (sensor.tactels - 1) - hair,
             sensor.length - sensor.tactel_width + hair) &&
          sensor.span() > 0,
      "tactel_span", sensor.span(),
      "a length in mm between the middles of the first and last tactel: no tactels overlap, none leaves the rubber");
  name(sensor.element);  // throws on a number that is no element
  name(sensor.stress);
}

const char* name(Element element) {
  switch (element) {
    case Element::bbar:
      return "bbar";
    case Element::q4:
      return "q4";
    case Element::q4i:
      return "q4i";
    case Element::q8:
      return "q8";
  }
  throw ValueError("sensor.element", std::to_string(static_cast<int>(element)), "bbar, q4, q4i or q8");
}

const char* name(StressRecovery recovery) {
  switch (recovery) {
    case StressRecovery::reaction:
      return "reaction";
    case StressRecovery::element:
      return "element";
  }
  throw ValueError("sensor.stress", std::to_string(static_cast<int>(recovery)), "reaction or element");
}

void require_compressible(const Sensor& sensor) {
  const double poisson = largest_poisson(sensor);
  if (!(poisson < 0.5))
    throw ValueError("sensor.poisson", number_text(poisson),
                     "below 0.5 on a mesh, whose stiffness is infinite there; a patch takes 0.5");
}

RubberLayer rubber_at(const Sensor& sensor, double height) {
  if (sensor.layers.empty()) return {sensor.thickness, sensor.young, sensor.poisson};
  auto layer = sensor.layers.begin();
  for (double top = layer->thickness; height > top && layer + 1 != sensor.layers.end(); top += layer->thickness)
    ++layer;
  return *layer;
}

Sensor with_unit_young(Sensor sensor, double poisson) {
  for (RubberLayer& layer : sensor.layers)
    layer.young /= sensor.young, layer.poisson = std::min(layer.poisson, poisson);
  sensor.young = 1, sensor.poisson = std::min(sensor.poisson, poisson);
  return sensor;
}

std::string layers_text(const Sensor& sensor) {
  std::string text;
  for (const auto& [thickness, young, poisson] : sensor.layers)
    text +=
        "layer " + number_text(thickness) + " " + number_text(young / sensor.young) + " " + number_text(poisson) + "\n";
  return text;
}

Eigen::VectorXd surface_positions(const Sensor& sensor) {
  const int intervals = sensor.columns - 1;
  Eigen::VectorXd x(sensor.columns);
  for (int i = 0; i <= intervals; ++i) x[i] = sensor.length * (2 * i - intervals) / (2.0 * intervals);
  return x;
}

}  // namespace tactel::fem
