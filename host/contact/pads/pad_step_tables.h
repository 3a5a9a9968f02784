// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_layer.h"
#include "fem/pad/side_kernel.h"

namespace tactel::host {

/// What cells fixed to a pad do to each other where that depends on their places:
/// [place][source] [displacement x, y, z][force x, y, z] mm by a traction of 1 at E = 1. Empty: of the pad's own
/// rubber, with its sides where they are free.
using PairInfluence = std::vector<double>;

/// What kernels/pad_step.cl takes of a pad and its cells.
struct StepTables {
  /// `markers`: places and depths of those whose displacements are asked for.
  StepTables(const fem::PadSensor& pad, const fem::PadCells& cells, const fem::SoftObject& object,
             const std::optional<fem::PadSides>& sides, const std::optional<Markers>& markers,
             const PairInfluence& pairs);

  std::vector<double> influence;              ///< of offsets; of pairs of cells: where given, or sides are free
  double kt = 0, kr = 0;                      ///< of a StickingDisc
  std::vector<double> stress, displacements;  ///< `base` of kernel pad_frames for tactels, and for markers
};

/// What kernels/pad/splitting.h takes of a grid of nx x ny cells.
struct SplitBlocks {
  /// Of fields even and odd along x and y, on a quarter of the grid: [2][4][rounds][rows][STEP_ROUND], B and
  /// (B + rho)^-1. Empty where the grid is not its own image along x and along y.
  std::vector<double> numbers;
  double rho_n = 1, rho_t = 1;  ///< over what a cell does to itself
};
/// `table`: the kernel's own, of pairs or of offsets.
SplitBlocks split_blocks(const std::vector<double>& table, bool pairs, int nx, int ny);

}  // namespace tactel::host
