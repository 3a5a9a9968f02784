// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/answer_error.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem {

/// Returns the options of the reference on so many cells along a side. A second path on half as many cells has twice as
/// many increments.
inline PadOptions pad_reference_options(int cells = 64) {
  return {.cells = cells,
          .tolerance = 1e-5,
          .pressing_increments = 8,
          .drag_increments = 2,
          .limit_increments = 3,
          .ladder = false};
}

/// An answer and what it may be off by.
struct PadReferenceSolution {
  PadSolution solution;
  AnswerError error;  ///< to expect
};

/// Returns the differences of the steps of two answers to one scene.
AnswerError pad_difference(const PadSolution& a, const PadSolution& b);

/// The judge of the pad solver's accuracy: many cells that just cover the contact, and sweeps in fp64. Answers converge
/// at first order in increments: with a of m and b of 2 m increments on half as many cells, totals and stresses are
/// those of m increments plus 2 (b - a); the tractions of cells are those of m increments. The error is the difference
/// from a, whose cells converge at order 1.5 at least, over 2^1.5 - 1. Pads with free sides take 32 cells at most, and
/// finer bricks. A scene takes ten seconds. Keeps a reference to the layer.
class PadReference {
 public:
  explicit PadReference(const PadLayer& layer, const PadOptions& options = pad_reference_options());
  PadReferenceSolution solve(const PadScene& scene) const;

 private:
  PadSolution solve_on(int cells, int parts, const PadScene& scene) const;

  const PadLayer& layer_;
  PadOptions options_;
};

}  // namespace tactel::fem
