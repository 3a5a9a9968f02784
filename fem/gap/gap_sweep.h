// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/contact_solution.h"
#include "fem/mesh/condensation.h"
#include "fem/scenes/scene.h"

namespace tactel::fem {

/// Twin of kernels/gap_sweep.cl for one scene at a time, under depth control: block Gauss-Seidel over gap
/// elements on the surface compliance, in plain Eigen. It shares the algorithm with the kernel, but no code.
/// fem/gap/gap_reference.h is the reference of both.
template <class Real>
class GapSweep {
 public:
  /// `tolerance`: largest change of a force in the last sweep over the largest pressure force.
  explicit GapSweep(const Condensation& condensation, double tolerance = 1e-11, int most_sweeps = 20000);
  /// Throws ValueError for a scene that is driven by force.
  ContactSolution solve(const Scene& scene) const;

 private:
  template <class Record>
  void step_load_path(const Scene& scene, const Record& record) const;

  const Condensation& condensation_;
  double tolerance_;
  int most_sweeps_;
  Eigen::Matrix<Real, -1, -1, Eigen::RowMajor> to_uy_,
      to_ux_;  ///< [columns, 2 columns]: displacement by n at 2j, by t at 2j + 1, E = 1
};

extern template class GapSweep<float>;
extern template class GapSweep<double>;

}  // namespace tactel::fem
