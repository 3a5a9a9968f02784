#pragma once
#include "fem/contact_solution.h"
#include "fem/scene.h"

namespace tactel::fem {

struct GapReferenceOptions {
  int most_iterations = 200;   ///< status changes tried per increment, safeguards included
  double tolerance = 1e-10;    ///< largest relative residual that counts as converged
};

/// Contact on the full finite element mesh, fp64: gap elements are open, sticking or slipping; each status iteration solves the
/// whole block with their conditions as constraints (no condensation), until no status changes. Judges the batched solver.
ContactSolution solve_gap_reference(const Scene& scene, const GapReferenceOptions& options = {});

}  // namespace tactel::fem
