// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/line_scene.h>

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

namespace tactel::fem {

using tactel::Element, tactel::StressRecovery;

/// The rubber layer and its transducers: all inputs of the condensation. Plane strain; x runs along the array
/// from -length/2 to length/2, y up from the base.
struct Sensor {
  double length = 20.0;    ///< mm
  double thickness = 1.5;  ///< mm; with layers their sum
  double young = 2.0;      ///< MPa; with layers that of the uppermost
  double poisson = 0.45;   ///< 0 <= nu <= 0.5; below 0.5 on a mesh; with layers that of the uppermost
  int columns = 41;        ///< mesh nodes along x (corners of elements; q8 adds its mid-side nodes)
  int rows = 11;           ///< mesh nodes through the thickness
  double grading = 4.0;    ///< bottom row height over top row height, geometric in between
  Element element = Element::bbar;
  int tactels = 21;                     ///< equally spaced
  std::optional<double> tactel_span{};  ///< mm from the middle of the first to that of the last; none: all that fits
  double tactel_width = 0;              ///< mm along x over which a tactel averages the stress; 0: a point
  StressRecovery stress = StressRecovery::reaction;
  std::vector<RubberLayer> layers{};  ///< from the base up, at most 8; none: one, of the numbers above

  bool operator==(const Sensor&) const = default;
  double span() const { return tactel_span.value_or(length - tactel_width); }
};
/// Throws ValueError, key "sensor.<member>".
void validate(const Sensor& sensor);
/// Throws ValueError for poisson = 0.5, which no mesh can model; patches can (fem/layer).
void require_compressible(const Sensor& sensor);

/// Returns the rubber at a height, mm.
RubberLayer rubber_at(const Sensor& sensor, double height);
/// Returns the sensor with E = 1 MPa at its surface, layers in proportion, and Poisson's ratios of at most `poisson`.
Sensor with_unit_young(Sensor sensor, double poisson = 0.5);
/// Returns a line for each layer, free of E, to the last digit: part of the key of a cache.
std::string layers_text(const Sensor& sensor);
/// Returns x of the columns, which carry the gap elements: [columns] mm, exactly symmetric about 0.
Eigen::VectorXd surface_positions(const Sensor& sensor);

// Largest block: a mistyped number beyond these would need more memory than a machine has.
inline constexpr int most_columns = 2001, most_rows = 1001, most_tactels = 10000;

const char* name(Element element);
const char* name(StressRecovery recovery);

}  // namespace tactel::fem
