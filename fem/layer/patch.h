// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>

#include "fem/scenes/indenter.h"

namespace tactel::fem {

/// Equal elements side by side on the part of the surface that an indenter touches.
struct Patch {
  double left = 0, right = 0;  ///< mm
  int elements = 0;
  bool reaches_left = false, reaches_right = false;  ///< ends at the sensor's end
  bool edge_left = false, edge_right = false;        ///< ends `edge_overhang` of an element beyond the indenter's edge

  double width() const { return (right - left) / elements; }        ///< of an element, mm
  double place(int i) const { return left + (i + 0.5) * width(); }  ///< middle of element i, mm; any i
};

/// Part of an element by which a patch reaches beyond an edge of the indenter that presses. Pressure is singular
/// there: with 0 the force of a flat is 3 % low at 12 elements, with this 0.15 %.
inline constexpr double edge_overhang = 0.15;

/// What limits a patch, mm along the array.
struct PatchLimits {
  Interval sensor;    ///< the surface
  Interval indenter;  ///< the indenter's own edges; infinite where it has none
};

/// Returns `elements` equal elements over the contact [left, right], clipped to the limits. A side that ends at an
/// edge of the indenter inside the sensor, and presses there, reaches `edge_overhang` beyond it.
Patch make_patch(Interval contact, const PatchLimits& limits, int elements);

/// Returns the middles of the elements, [elements] mm.
Eigen::VectorXd places(const Patch& patch);

}  // namespace tactel::fem
