// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_solver.h"

namespace tactel::fem {

struct PadReferenceOptions {
  int cells = 64;               ///< along a side
  double tolerance = 1e-5;      ///< of the sweeps
  int pressing_increments = 8;  ///< of the first of two paths; the other has twice as many
  int drag_increments = 2;      ///< of each drag, alike
  bool errors = true;           ///< estimate the error by a second answer on half as many cells
};

/// An answer and what it may be off by.
struct PadReferenceSolution {
  PadSolution solution;
  /// Expected errors: of S and P (largest of all steps, P relative to its own), of Q and M over the larger of both (M
  /// over the half size of the cells), and of the base stress over its largest.
  struct Errors {
    double slip_index = 0, P = 0, Q = 0, M = 0, stress = 0;
  };
  Errors error;
};

/// Returns the differences of the steps of two answers to one scene, as PadReferenceSolution has errors.
PadReferenceSolution::Errors pad_difference(const PadSolution& a, const PadSolution& b);

/// The judge of the pad solver's accuracy: many cells that just cover the contact, sweeps in fp64, and two paths of m
/// and 2 m increments. Answers converge at first order in increments: totals and stresses are 2 b - a of both; the
/// tractions of cells are those of the longer path. The error is the difference from half as many cells, which converge
/// at order 1.5 at least, over 2^1.5 - 1. A scene takes half a minute. Keeps a reference to the layer.
class PadReference {
 public:
  explicit PadReference(const PadLayer& layer, const PadReferenceOptions& options = {});
  PadReferenceSolution solve(const PadScene& scene) const;

 private:
  PadSolution extrapolated(const PadScene& scene, int cells) const;

  const PadLayer& layer_;
  PadReferenceOptions options_;
};

}  // namespace tactel::fem
