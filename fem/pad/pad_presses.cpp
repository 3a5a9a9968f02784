// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_presses.h"

#include <algorithm>
#include <utility>

namespace tactel::fem {

std::size_t presses_on(const PadLoad& load) {
  if (!load.times.empty()) return 0;
  const std::vector<PadTarget> targets = pad_targets(load);
  const std::size_t pressing = pressing_targets(load);
  std::size_t k = 0;
  while (k < pressing && (k == 0 || targets[k].normal >= targets[k - 1].normal)) ++k;
  return k;
}

std::vector<std::size_t> coarse_presses(const PadScene& scene, const PadSolution& solution) {
  return coarse_presses(scene.load, solution.cells.n, [&](std::size_t k) { return solution.steps[k].across; });
}

PadScene pressed_alone(const PadScene& scene, std::size_t k) {
  PadScene alone = scene;
  const double normal = pad_targets(scene.load)[k].normal;
  alone.load = {};
  (by_force(scene) ? alone.load.normal_force : alone.load.indentation) = {normal};
  if (by_force(scene)) alone.load.indentation.clear();
  return alone;
}

void take_alone(PadSolution& solution, std::size_t k, const PadSolution& alone) {
  PadStep step = alone.steps.back();
  const Eigen::VectorXd n = std::move(step.normal_force);
  const Eigen::MatrixX2d t = std::move(step.tangential_force);
  const std::vector<GapStatus> status = std::move(step.status);
  const Eigen::Index count = solution.places.rows();
  step.normal_force = Eigen::VectorXd::Zero(count);
  step.tangential_force = Eigen::MatrixX2d::Zero(count, 2);
  step.status.assign(count, GapStatus::open);
  for (Eigen::Index i = 0; i < n.size(); ++i) {
    if (!(n[i] > 0)) continue;
    Eigen::Index at = 0;
    (solution.places.rowwise() - alone.places.row(i)).rowwise().squaredNorm().minCoeff(&at);
    step.normal_force[at] += n[i];
    step.tangential_force.row(at) += t.row(i);
    GapStatus& now = step.status[at];
    if (now != GapStatus::stick) now = status[i];  // a cell of which a part sticks
  }
  solution.steps[k] = std::move(step);
}

}  // namespace tactel::fem
