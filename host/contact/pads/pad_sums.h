// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "host/contact/contact_batch.h"
#include "host/contact/pads/pad_lanes.h"

namespace tactel::host {

/// What a launch of pad_base_stress sums at places on the pad, for scenes in lanes.
template <class Real>
struct PadSums {
  /// The stress under tactels. `width`: lanes of a vector.
  static PadSums stress(const LaneState<Real>& lanes, const std::vector<PadOnCells>& scenes, PadRubbers& rubbers,
                        std::size_t width);
  /// Displacements of the scenes' markers. Points lie evenly over a cell, as near to each other as the markers to the
  /// surface: a lone cell's miss 3 % of its own there. Shallower markers have none, and `count` is 0.
  static PadSums markers(const LaneState<Real>& lanes, const std::vector<PadOnCells>& scenes, PadRubbers& rubbers,
                         std::size_t width);

  int rows = 0, rows_a_thickness = 0;  ///< of a table
  int count = 0, parts = 0;            ///< places; points of each
  std::size_t groups = 0;
  Buffer<Real> tables{}, shares{}, points{}, weights{};
  LaneArray<Real> cells{};  ///< where they lie, PAD_PLACE_ROWS
};

}  // namespace tactel::host
