#include "fem/gap_reference.h"

#include <algorithm>
#include <stdexcept>

#include "fem/block.h"

namespace tactel::fem {
namespace {

GapBlock make_block(const Sensor& sensor) {
  Mesh mesh = make_mesh(sensor);
  Eigen::SparseMatrix<double> matrix = stiffness(mesh, sensor);
  return {std::move(mesh), std::move(matrix)};
}

bool every_touching_node_slips(const ContactStep& step) {
  const auto is = [](GapStatus status) { return [status](GapStatus other) { return other == status; }; };
  return std::any_of(step.status.begin(), step.status.end(), is(GapStatus::slip)) &&
         std::none_of(step.status.begin(), step.status.end(), is(GapStatus::stick));
}

}  // namespace

GapReference::GapReference(const Sensor& sensor, const GapReferenceOptions& options)
    : sensor_(sensor),
      options_(options),
      block_(make_block(sensor)),
      surface_x_(surface_positions(sensor)),
      tactel_x_(tactel_positions(sensor)) {
  const Mesh& mesh = block_.mesh();
  base_x_ = mesh.node(0, mesh.base).transpose();
  if (sensor.stress == StressRecovery::reaction) {
    stress_of_reaction_ = base_stress_from_reaction(mesh, sensor);
  } else {
    stress_of_elements_ = base_stress_from_elements(mesh, sensor);
  }
}

ContactStep GapReference::step_of(const GapIncrement& increment, const GapAnswer& answer) const {
  const GapElements elements = elements_of(increment, answer.pose);
  ContactStep step;
  step.indentation = answer.pose.depth;
  step.tangential = answer.pose.tangential;
  step.normal_force = elements.normal_force;
  step.tangential_force = elements.tangential_force;
  step.P = elements.normal_force.sum();
  step.Q = elements.tangential_force.sum();
  if (increment.mu * step.P > 0) step.slip_index = step.Q / (increment.mu * step.P);
  step.status = gap_status(elements);
  const Eigen::VectorXd base = block_.base_force(answer.pose.displacement).cast<double>();
  step.base_force_x = base(Eigen::seq(0, Eigen::last, 2));
  step.base_force_y = base(Eigen::seq(1, Eigen::last, 2));
  if (sensor_.stress == StressRecovery::reaction) {
    step.sigma_y = stress_of_reaction_ * step.base_force_y;
    step.tau_xy = stress_of_reaction_ * step.base_force_x;
  } else {
    const Eigen::VectorXd stress = stress_of_elements_ * answer.pose.displacement.cast<double>();
    step.sigma_y = stress.head(tactel_x_.size());
    step.tau_xy = stress.tail(tactel_x_.size());
  }
  step.converged = answer.converged;
  step.iterations = answer.iterations;
  step.residual = answer.residual;
  return step;
}

ContactSolution GapReference::solve(const Scene& scene) {
  scene.validate();
  if (scene.sensor != sensor_)
    throw std::invalid_argument("GapReference::solve: the scene has another sensor than the solver");
  const LoadPath path = load_path(scene.load);
  const Eigen::VectorXd height = profile_heights(scene.indenter, surface_x_);
  ContactSolution solution{surface_x_, base_x_, tactel_x_, {}, false};
  GapPose pose = undeformed(block_, height);
  for (const LoadStep& target : path.steps) {
    const GapIncrement increment{block_, scene.friction, height, target, pose};
    GapAnswer answer = solve_increment(increment, options_.most_iterations, options_.tolerance);
    solution.steps.push_back(step_of(increment, answer));
    pose = std::move(answer.pose);
    const bool tangential = int(solution.steps.size()) > path.indentation_steps;
    solution.sliding = tangential && every_touching_node_slips(solution.steps.back());
    if (path.until_sliding && solution.sliding) break;
  }
  return solution;
}

ContactSolution solve_gap_reference(const Scene& scene, const GapReferenceOptions& options) {
  return GapReference(scene.sensor, options).solve(scene);
}

}  // namespace tactel::fem
