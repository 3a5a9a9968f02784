// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_solver.h"
#include "host/calibration/press_model.h"

namespace tactel::host {

/// A number of a pad's indenter that moves none of its sharp edges.
struct PadShapeNumber {
  std::string key;  ///< "radius", "radii[0]"
  const char* unit;
  double* value;
};
std::vector<PadShapeNumber> pad_shape_numbers(fem::PadShape& shape);

/// A press on a pad, solved by fem::PadSolver, with derivatives by differences on the same cells.
class PadPress : public PressModel {
 public:
  /// As LinePress, on cells x cells cells; each drag has `drag_increments`. Throws ValueError for a contact that is too
  /// near an edge of the pad, or that such cells do not serve.
  PadPress(const fem::PadScene& scene, const PressTiming& timing, const SensorState& first, int cells,
           int drag_increments);

 private:
  PressFrames stresses(const SensorState& state, double friction, std::span<const PressNumber> numbers) const override;
  PressFrames solve(const SensorState& state, const fem::PadScene& scene) const;

  fem::PadScene scene_;  ///< each target of its pressing stands by itself
  fem::PadOptions options_;
  fem::PadCells cells_;
};

}  // namespace tactel::host
