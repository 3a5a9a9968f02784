// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_reference.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {

PadReferenceSolution::Errors pad_difference(const PadSolution& a, const PadSolution& b) {
  PadReferenceSolution::Errors e;
  double tangential = 0, stress = 0, Q = 0, M = 0, stress_off = 0;
  const double size = b.cells.half_size();
  for (std::size_t k = 0; k < b.steps.size(); ++k) {
    const PadStep &p = a.steps[k], &q = b.steps[k];
    e.slip_index = std::max(e.slip_index, std::abs(p.slip_index.value_or(0) - q.slip_index.value_or(0)));
    if (q.P > 0) e.P = std::max(e.P, std::abs(p.P / q.P - 1));
    Q = std::max(Q, (p.Q - q.Q).norm());
    M = std::max(M, std::abs(p.M - q.M) / size);
    tangential = std::max({tangential, q.Q.norm(), std::abs(q.M) / size});
    stress_off = std::max(stress_off, (p.stress - q.stress).cwiseAbs().maxCoeff());
    stress = std::max(stress, q.stress.cwiseAbs().maxCoeff());
  }
  if (tangential > 0) e.Q = Q / tangential, e.M = M / tangential;
  if (stress > 0) e.stress = stress_off / stress;
  return e;
}

PadReference::PadReference(const PadLayer& layer, const PadReferenceOptions& options)
    : layer_(layer), options_(options) {}

PadSolution PadReference::extrapolated(const PadScene& scene, int cells) const {
  PadOptions options{.cells = cells, .tolerance = options_.tolerance, .ladder = false};
  options.halve_turns = false;
  options.pressing_increments = options_.pressing_increments;
  options.drag_increments = options_.drag_increments;
  const PadSolution a = PadSolver(layer_, options).solve(scene);
  options.pressing_increments *= 2;
  options.drag_increments *= 2;
  PadSolution b = PadSolver(layer_, options).solve(scene);
  for (std::size_t k = 0; k < b.steps.size(); ++k) {
    const PadStep& p = a.steps[k];
    PadStep& q = b.steps[k];
    q.P = 2 * q.P - p.P;
    q.Q = 2 * q.Q - p.Q;
    q.M = 2 * q.M - p.M;
    q.stress = 2 * q.stress - p.stress;
    if (q.slip_index && p.slip_index) q.slip_index = std::min(2 * *q.slip_index - *p.slip_index, 1.0);
    if (q.force_ratio) q.force_ratio = q.Q.norm() / (scene.friction * q.P);
    q.converged &= p.converged;
  }
  return b;
}

PadReferenceSolution PadReference::solve(const PadScene& scene) const {
  PadReferenceSolution answer{extrapolated(scene, options_.cells), {}};
  if (!options_.errors) return answer;
  answer.error = pad_difference(extrapolated(scene, options_.cells / 2), answer.solution);
  const double rest = 1 / (std::exp2(1.5) - 1);
  for (double* e : {&answer.error.slip_index, &answer.error.P, &answer.error.Q, &answer.error.M, &answer.error.stress})
    *e *= rest;
  return answer;
}

}  // namespace tactel::fem
