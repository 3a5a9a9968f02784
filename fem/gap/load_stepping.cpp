// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/load_stepping.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {
namespace {

bool has(const ContactStep& step, GapStatus status) {
  return std::find(step.status.begin(), step.status.end(), status) != step.status.end();
}

/// mm: as ContactStep has it.
double slip_distance(const GapIncrement& increment, const GapPose& pose, const GapElements& elements) {
  const Extended u = increment.system.surface_displacement(pose.state);
  double farthest = 0;
  for (Eigen::Index i = 0; i < pose.gap.size(); ++i)
    if (elements.normal_force[i] > 0) farthest = std::max(farthest, std::abs(pose.tangential - double(u(2 * i))));
  return farthest;
}

ContactStep step_of(const GapIncrement& increment, const GapAnswer& answer, const TactelStress& stress) {
  const GapElements elements = elements_of(increment, answer.pose);
  ContactStep step;
  step.indentation = answer.pose.depth;
  step.tangential = answer.pose.tangential;
  step.normal_force = elements.normal_force;
  step.tangential_force = elements.tangential_force;
  step.P = elements.normal_force.sum();
  step.Q = elements.tangential_force.sum();
  step.slip_index = slip_index(increment.mu, step.P, step.Q);
  step.slip_distance = slip_distance(increment, answer.pose, elements);
  step.status = gap_status(elements);
  const Eigen::VectorXd base = increment.system.base_force(answer.pose.state).cast<double>();
  step.base_force_x = base(Eigen::seq(0, Eigen::last, 2));
  step.base_force_y = base(Eigen::seq(1, Eigen::last, 2));
  const Eigen::VectorXd tactels = stress(answer.pose.state, base);
  step.sigma_y = tactels.head(tactels.size() / 2);
  step.tau_xy = tactels.tail(tactels.size() / 2);
  step.converged = answer.converged;
  step.iterations = answer.iterations;
  step.residual = answer.residual;
  return step;
}

}  // namespace

ContactSolution step_load_path(GapSystem& system, const Scene& scene, ContactSolution positions,
                               const GapReferenceOptions& options, const TactelStress& stress) {
  scene.validate();
  const LoadPath path = load_path(scene.load);
  const Eigen::VectorXd height = profile_heights(scene.indenter, positions.surface_x);
  const double mu = std::min(scene.friction, largest_friction);
  ContactSolution solution = std::move(positions);
  GapPose pose = undeformed(system, height);
  for (const LoadStep& target : path.steps) {
    const GapIncrement increment{system, mu, height, target, pose};
    GapAnswer answer = solve_increment(increment, options.most_iterations, options.tolerance);
    const bool history = solution.steps.empty() || solution.steps.back().converged;
    solution.steps.push_back(step_of(increment, answer, stress));
    solution.steps.back().converged &= history;
    pose = std::move(answer.pose);
    const bool tangential = int(solution.steps.size()) > path.indentation_steps;
    const bool sticks = has(solution.steps.back(), GapStatus::stick);
    solution.sliding = tangential && !sticks && has(solution.steps.back(), GapStatus::slip);
    if (path.until_sliding && tangential && !sticks) break;  // where nothing touches, nothing ever will
  }
  return solution;
}

int pressing_parts(const Load& load, int increments) {
  return (increments + load.indentation_steps - 1) / load.indentation_steps;
}

void keep_own_steps(ContactSolution& solution, const Load& load, int parts) {
  const std::size_t pressed = static_cast<std::size_t>(load_path(load).indentation_steps) * parts;
  std::vector<ContactStep> asked;
  for (std::size_t k = 0; k < solution.steps.size(); ++k)
    if (k >= pressed || (k + 1) % parts == 0) asked.push_back(std::move(solution.steps[k]));
  solution.steps = std::move(asked);
}

}  // namespace tactel::fem
