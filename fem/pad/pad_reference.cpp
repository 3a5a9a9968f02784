// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_reference.h"

#include <algorithm>
#include <cmath>

#include "fem/pad/pad_markers.h"
#include "fem/pad/side_kernel.h"

namespace tactel::fem {

AnswerError pad_difference(const PadSolution& a, const PadSolution& b) {
  AnswerError e;
  double pressing = 0, tangential = 0, sigma = 0, tau = 0, farthest = 0;
  const double size = b.cells.half_size();
  for (std::size_t k = 0; k < b.steps.size(); ++k) {
    const PadStep &p = a.steps[k], &q = b.steps[k];
    e.S = std::max(e.S, std::abs(p.slip_index.value_or(0) - q.slip_index.value_or(0)));
    e.P = std::max(e.P, std::abs(p.P - q.P)), pressing = std::max(pressing, q.P);
    e.Q = std::max(e.Q, (p.Q - q.Q).norm());
    e.M = std::max(e.M, std::abs(p.M - q.M) / size);
    tangential = std::max({tangential, q.Q.norm(), std::abs(q.M) / size});
    const Eigen::MatrixX3d off = (p.stress - q.stress).cwiseAbs();
    e.sigma = std::max(e.sigma, off.col(0).maxCoeff()), e.tau = std::max(e.tau, off.rightCols<2>().maxCoeff());
    sigma = std::max(sigma, q.stress.col(0).cwiseAbs().maxCoeff());
    tau = std::max(tau, q.stress.rightCols<2>().cwiseAbs().maxCoeff());
    if (p.markers.rows() != q.markers.rows() || q.markers.rows() == 0) continue;
    e.markers = std::max(e.markers, (p.markers - q.markers).cwiseAbs().maxCoeff());
    farthest = std::max(farthest, q.markers.cwiseAbs().maxCoeff());
  }
  if (pressing > 0) e.P /= pressing;
  if (tangential > 0) e.Q /= tangential, e.M /= tangential;
  if (sigma > 0) e.sigma /= sigma;
  if (tau > 0) e.tau /= tau;
  if (farthest > 0) e.markers /= farthest;
  return e;
}

PadReference::PadReference(const PadLayer& layer, const PadOptions& options) : layer_(layer), options_(options) {}

/// With `parts` times the increments of the options.
PadSolution PadReference::solve_on(int cells, int parts, const PadScene& scene) const {
  PadOptions options = options_;
  options.cells = cells, options.parts = parts, options.side_bricks = SideBricks::finest;
  PadSolution solution = PadSolver(layer_, options).solve(scene);
  see_markers(scene, solution, options.between_sweeps);
  return solution;
}

PadReferenceSolution PadReference::solve(const PadScene& scene) const {
  const SideRules rules = side_rules(scene.sensor);
  const int cells = std::min(options_.cells, rules.most_cells);
  PadReferenceSolution answer{solve_on(cells, 1, scene), {}};
  const PadSolution a = solve_on(cells / 2, 1, scene), b = solve_on(cells / 2, 2, scene);
  answer.error = pad_difference(a, answer.solution);
  auto& e = answer.error;
  for (const auto member : pad_error_members) e.*member /= std::exp2(rules.order) - 1;
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    const PadStep &few = a.steps[k], &many = b.steps[k];
    PadStep& step = answer.solution.steps[k];
    step.P += 2 * (many.P - few.P);
    step.Q += 2 * (many.Q - few.Q);
    step.M += 2 * (many.M - few.M);
    step.stress += 2 * (many.stress - few.stress);
    step.markers += 2 * (many.markers - few.markers), step.pixels += 2 * (many.pixels - few.pixels);
    if (step.slip_index && few.slip_index && many.slip_index)
      step.slip_index = std::clamp(*step.slip_index + 2 * (*many.slip_index - *few.slip_index), 0.0, 1.0);
    if (step.force_ratio) step.force_ratio = step.Q.norm() / (step.mu * step.P);
    step.converged &= few.converged && many.converged;
  }
  return answer;
}

}  // namespace tactel::fem
