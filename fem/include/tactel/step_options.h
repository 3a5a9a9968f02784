// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>

namespace tactel {

/// How contacts are stepped (docs/stepping.md).
struct StepOptions {
  int cells = 16;                 ///< along a side of the grid, which is fixed to the pad about its middle; 4 to 24
  double cell = 0.5;              ///< mm, side of a cell
  double tolerance = 1e-3;        ///< of the sweeps: largest change of a traction over the largest pressure
  double force_tolerance = 2e-3;  ///< of a wrench, over its P
  int most_sweeps = 400;          ///< of a pose
  int most_solves = 16;           ///< poses that a step by wrench may solve
  std::string precision{};        ///< "fp32", "fp64"; empty: fp32
  std::string device{};           ///< name or index of an OpenCL device; empty: the default device
};

/// What a step says of a contact, a sum of these.
enum StepFlag : std::uint32_t {
  step_open = 1,      ///< nothing touches
  step_slides = 2,    ///< every cell that touches slips, or the wrench is beyond what friction bears
  step_unmet = 4,     ///< the wrench was not met, or the sweeps did not settle
  step_edge = 8,      ///< an outermost cell touches: the contact may reach beyond the grid
  step_invalid = 16,  ///< numbers that are no input: the contact stays as it was
};

}  // namespace tactel
