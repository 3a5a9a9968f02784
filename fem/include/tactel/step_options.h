// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/pad_scene.h>

#include <cstdint>
#include <optional>
#include <string>

namespace tactel {

/// A number for x and y alike, or one for each.
template <class Number>
struct AlongXY {
  Number x{}, y{};
  bool given = false;  ///< false: by the pad

  constexpr AlongXY() = default;
  constexpr AlongXY(Number both) : x(both), y(both), given(true) {}
  constexpr AlongXY(Number x, Number y) : x(x), y(y), given(true) {}
};

/// How contacts are stepped (docs/stepping.md). The grid is fixed to the pad about its middle.
struct StepOptions {
  /// Cells along x and y, 4 to 24. By the pad: 16 x 16; of free sides some 256 that are nearly square.
  AlongXY<int> cells{};
  /// mm, sides of a cell. By the pad: 0.5; those that just cover a pad with free sides.
  AlongXY<double> cell{};
  double tolerance = 1e-3;        ///< of the sweeps: largest change of a traction over the largest pressure
  double force_tolerance = 2e-3;  ///< of a wrench, over its P
  int most_sweeps = 400;          ///< of a pose
  int most_solves = 16;           ///< poses that a step by wrench may solve
  double object_young = 0;        ///< MPa, of the objects, as of PadIndenter; 0: rigid
  double object_poisson = 0.45;
  std::string precision{};           ///< "fp32", "fp64"; empty: fp32
  std::string device{};              ///< name or index of an OpenCL device; empty: the default device
  double dt = 0;                     ///< seconds of a step, of a pad that relaxes
  std::optional<Markers> markers{};  ///< whose displacements steps have
  std::optional<Camera> camera{};    ///< that sees them
};

/// What a step says of a contact, a sum of these.
enum StepFlag : std::uint32_t {
  step_open = 1,      ///< nothing touches
  step_slides = 2,    ///< every cell that touches slips, or the wrench is beyond what friction bears
  step_unmet = 4,     ///< the wrench was not met, or the sweeps did not settle
  step_edge = 8,      ///< an outermost cell touches beside rubber beyond the grid: the contact may reach there
  step_invalid = 16,  ///< numbers that are no input: the contact stays as it was
  step_deep = 32,     ///< deeper than the linear model holds: faces from 0.05 of the thickness, curved objects 0.25
  step_reach = 64,    ///< the object lies deeper than the surface of rubber beyond the grid
};

}  // namespace tactel
