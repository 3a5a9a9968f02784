// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "fem/gap/load_stepping.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem {

/// Exact contact on the surface compliance, fp64: the reference's active-set method with C instead of the mesh.
/// It is much faster than the reference on fine meshes, and solves scenes that the batched solver could not
/// solve. Keeps a reference to the condensation.
class GapCondensed {
 public:
  explicit GapCondensed(const Condensation& condensation, const GapReferenceOptions& options = {});

  /// Solves a scene. Its sensor must equal that of the condensation, except for E.
  ContactSolution solve(const Scene& scene) const;

 private:
  const Condensation& condensation_;
  GapReferenceOptions options_;
  Extended compliance_, base_force_;  ///< C and T, for sums in extended precision
};

}  // namespace tactel::fem
