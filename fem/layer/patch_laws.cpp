// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_laws.h"

namespace tactel::fem {

PatchLaws patch_laws(const PatchCompliance& compliance, double w) {
  const Eigen::Index n = compliance.uy_by_n.cols();
  const auto within = [&](const PatchCompliance::Matrix& part) { return part.middleRows(rows_beyond, n); };
  PatchLaws laws;
  laws.n_per_uy = -w * within(compliance.uy_by_n).diagonal().cwiseInverse();
  laws.t_per_ux = w * within(compliance.ux_by_t).diagonal().cwiseInverse();
  laws.A = laws.n_per_uy.asDiagonal() * within(compliance.uy_by_n);
  laws.B = laws.n_per_uy.asDiagonal() * within(compliance.uy_by_t);
  laws.D = (-laws.t_per_ux).asDiagonal() * within(compliance.ux_by_n);
  laws.E = (-laws.t_per_ux).asDiagonal() * within(compliance.ux_by_t);
  laws.A.diagonal().setConstant(1 - w);
  laws.E.diagonal().setConstant(1 - w);
  return laws;
}

}  // namespace tactel::fem
