// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_compliance.h"

#include <cmath>

#include "fem/layer/element_compliance.h"
#include "fem/mesh/block.h"

namespace tactel::fem {

PatchCompliance patch_compliance(const LayerModel& model, const Patch& patch) {
  const int n = patch.elements, rows = n + 2 * rows_beyond;
  const ElementCompliance layer =
      element_compliance(model.table, model.sensor.thickness, patch.width(), n + rows_beyond);
  std::vector<FreeSides::At> sides;
  for (int i = -rows_beyond; i < n + rows_beyond; ++i) sides.push_back(model.sides.at(patch.place(i)));
  PatchCompliance c;
  for (auto* part : {&c.uy_by_n, &c.uy_by_t, &c.ux_by_n, &c.ux_by_t}) part->resize(rows, n);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < n; ++j) {
      const int k = i - rows_beyond - j;
      const FreeSides::At &at = sides[i], &by = sides[j + rows_beyond];
      const double coupling = k < 0 ? -layer.xy[-k] : layer.xy[k];  // u_x by f_y
      c.uy_by_n(i, j) = -(layer.yy[std::abs(k)] + model.sides.between(at.y, by.y));
      c.uy_by_t(i, j) = -coupling + model.sides.between(at.y, by.x);
      c.ux_by_n(i, j) = -(coupling + model.sides.between(at.x, by.y));
      c.ux_by_t(i, j) = layer.xx[std::abs(k)] + model.sides.between(at.x, by.x);
    }
  return c;
}

Condensation without_compliance(const LayerModel& model, const Eigen::VectorXd& places) {
  const Eigen::Index n = places.size(), tactels = model.base.tactels();
  Condensation result;
  result.surface_x = places;
  result.tactel_x = tactel_positions(model.sensor);
  result.base_x = Eigen::VectorXd::Zero(1);
  result.compliance.resize(2 * n, 2 * n);
  result.base_force = Eigen::MatrixXd::Zero(2, 2 * n);
  result.tactel_stress.resize(2 * tactels, 2 * n);
  for (Eigen::Index j = 0; j < n; ++j) {
    result.base_force.block<2, 2>(0, 2 * j).setIdentity();
    const Eigen::VectorXd stress = model.base.at(places[j]);
    const auto part = [&](BaseStressTable::Quantity quantity) { return stress.segment(quantity * tactels, tactels); };
    result.tactel_stress.col(2 * j) << part(BaseStressTable::sigma_by_traction), part(BaseStressTable::tau_by_traction);
    result.tactel_stress.col(2 * j + 1) << -part(BaseStressTable::sigma_by_pressure),
        -part(BaseStressTable::tau_by_pressure);
  }
  return result;
}

Condensation patch_condensation(const LayerModel& model, const Patch& patch) {
  const PatchCompliance c = patch_compliance(model, patch);
  Condensation result = without_compliance(model, places(patch));
  for (Eigen::Index j = 0; j < patch.elements; ++j)
    for (Eigen::Index i = 0; i < patch.elements; ++i) {
      const Eigen::Index row = i + rows_beyond;
      result.compliance.block<2, 2>(2 * i, 2 * j) << c.ux_by_t(row, j), -c.ux_by_n(row, j), c.uy_by_t(row, j),
          -c.uy_by_n(row, j);
    }
  return result;
}

}  // namespace tactel::fem
