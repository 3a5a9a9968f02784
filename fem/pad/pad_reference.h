// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/answer_error.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem {

struct PadReferenceOptions {
  int cells = 64;               ///< along a side
  double tolerance = 1e-5;      ///< of the sweeps
  int pressing_increments = 8;  ///< of the path; a second one on half as many cells has twice as many
  int drag_increments = 2;      ///< of each drag at least, alike
  int limit_increments = 3;     ///< of a drag to the sliding limit (pad_increments), alike
};

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
/// from a, whose cells converge at order 1.5 at least, over 2^1.5 - 1. A scene takes ten seconds. Keeps a reference to
/// the layer.
class PadReference {
 public:
  explicit PadReference(const PadLayer& layer, const PadReferenceOptions& options = {});
  PadReferenceSolution solve(const PadScene& scene) const;

 private:
  PadSolution solve_on(int cells, int parts, const PadScene& scene) const;

  const PadLayer& layer_;
  PadReferenceOptions options_;
};

}  // namespace tactel::fem
