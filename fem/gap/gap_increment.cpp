// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/gap_increment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "fem/gap/gap_path.h"

namespace tactel::fem {
namespace {

// Poses are exact to rounding of what they are given; a law is violated beyond a multiple of it, so that ties (n = 0 at
// gap = 0, |t| = mu n at slip = 0) count as met by either status and cannot make the iteration cycle.
constexpr double tie = 64 * std::numeric_limits<double>::epsilon();

GapPose pose_at(const GapIncrement& increment, const std::vector<Trial>& trial, const Eigen::Vector3d& position,
                Extended state) {
  const GapSystem& system = increment.system;
  const Extended u = system.surface_displacement(state), f = system.surface_force(state);
  const Extended before = system.surface_displacement(increment.previous.state);
  const int n = system.columns();
  GapPose pose;
  pose.trial = trial;
  pose.depth = position[1], pose.tangential = position[2];
  pose.state = std::move(state);
  pose.gap.resize(n), pose.slip.resize(n), pose.normal_force.resize(n), pose.tangential_force.resize(n);
  for (int i = 0; i < n; ++i) {
    pose.gap[i] = double(static_cast<long double>(increment.height[i]) - pose.depth - u(2 * i + 1));
    pose.slip[i] = double(u(2 * i) - before(2 * i) - pose.tangential + increment.previous.tangential);
    pose.tangential_force[i] = double(f(2 * i));
    pose.normal_force[i] = double(-f(2 * i + 1));
  }
  pose.force_tie = tie * double(f.cwiseAbs().maxCoeff());
  pose.length_tie = tie * (double(u.cwiseAbs().maxCoeff()) + std::abs(pose.depth) + std::abs(pose.tangential));
  return pose;
}

Trial next(const GapIncrement& increment, const GapPose& pose, Eigen::Index i) {
  const Trial trial = pose.trial[i];
  const double n = pose.normal_force[i], t = pose.tangential_force[i];
  if (trial == Trial::open) {
    if (!(pose.gap[i] < -pose.length_tie)) return Trial::open;
    return increment.mu == 0 ? Trial::slip_plus : Trial::stick;
  }
  if (n < -pose.force_tie) return Trial::open;
  if (increment.mu == 0) return Trial::slip_plus;
  if (trial == Trial::stick) {
    if (std::abs(t) <= increment.mu * std::max(0.0, n) + pose.force_tie) return Trial::stick;
    return t > 0 ? Trial::slip_plus : Trial::slip_minus;
  }
  return friction_sign(trial) * pose.slip[i] > pose.length_tie ? Trial::stick : trial;
}

}  // namespace

GapPose undeformed(const GapSystem& system, const Eigen::VectorXd& height) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(system.columns());
  GapPose pose;
  pose.trial.assign(system.columns(), Trial::open);
  pose.depth = height.minCoeff();
  pose.state = Extended::Zero(system.state_size(), 1);
  pose.gap = height.array() - pose.depth;
  pose.slip = pose.normal_force = pose.tangential_force = zero;
  return pose;
}

Extended right_side(const GapIncrement& increment, const std::vector<Trial>& trial) {
  const GapPose& previous = increment.previous;
  const Extended before = increment.system.surface_displacement(previous.state);
  Extended result = Extended::Zero(2 * trial.size(), 3);
  for (int i = 0; i < int(trial.size()); ++i) {
    if (!touches(trial[i])) continue;
    result.row(2 * i + 1) << increment.height[i], -1, 0;
    if (slips(trial[i])) continue;
    result.row(2 * i) << before(2 * i) - previous.tangential, 0, 1;
  }
  return result;
}

std::optional<Eigen::Vector3d> indenter_position(const LoadStep& target, const Extended& force) {
  Eigen::Matrix3d equations = Eigen::Matrix3d::Identity();
  Eigen::Vector3d values(1, target.normal, target.tangential);
  const auto sum = [&](int direction) -> Eigen::RowVector3d {
    Eigen::RowVector3d total = Eigen::RowVector3d::Zero();
    for (Eigen::Index i = direction; i < force.rows(); i += 2) total += force.row(i).cast<double>();
    return total;
  };
  if (target.normal_is_force) equations.row(1) = -sum(1);  // pressure points down
  if (target.tangential_is_force) equations.row(2) = sum(0);
  // Rows of forces and of lengths differ in unit: scaled before the rank is judged.
  for (int row = 1; row < 3; ++row) {
    const double scale = equations.row(row).tail<2>().cwiseAbs().maxCoeff();
    if (!(scale > 0)) return std::nullopt;
    equations.row(row) /= scale;
    values[row] /= scale;
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(equations);
  if (!lu.isInvertible()) return std::nullopt;
  return lu.solve(values);
}

std::optional<GapPose> pose_of(const GapIncrement& increment, const std::vector<Trial>& trial) {
  GapSystem& system = increment.system;
  const LoadStep& to = increment.target;
  Extended right = right_side(increment, trial);
  std::optional<Eigen::Vector3d> position;
  if (!to.normal_is_force && !to.tangential_is_force) {
    position = Eigen::Vector3d(1, to.normal, to.tangential);
    right = (right * position->cast<long double>()).eval();
  }
  const auto response = system.solve(trial, increment.mu, right);
  if (!response) return std::nullopt;
  if (position) return pose_at(increment, trial, *position, *response);
  position = indenter_position(to, system.surface_force(*response));
  if (!position) return std::nullopt;
  return pose_at(increment, trial, *position, *response * position->cast<long double>());
}

std::vector<Trial> next_trial(const GapIncrement& increment, const GapPose& pose) {
  std::vector<Trial> result(pose.trial.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = next(increment, pose, Eigen::Index(i));
  return result;
}

GapElements elements_of(const GapIncrement& increment, const GapPose& pose) {
  const Eigen::VectorXd base = increment.system.base_force(pose.state).cast<double>();
  GapElements elements{increment.mu, pose.gap, pose.slip, pose.normal_force, pose.tangential_force};
  elements.base_force = base.reshaped(2, base.size() / 2).rowwise().sum();
  const Extended u = increment.system.surface_displacement(pose.state);
  elements.largest_displacement = double(u.reshaped(2, pose.gap.size()).colwise().norm().maxCoeff());
  for (Eigen::Index i = 0; i < pose.gap.size(); ++i) {
    // Open elements bear nothing; what K u shows there, and a pull within rounding, is rounding.
    const bool bears = touches(pose.trial[i]) && (pose.normal_force[i] > 0 || pose.normal_force[i] < -pose.force_tie);
    if (!bears) elements.normal_force[i] = elements.tangential_force[i] = 0;
  }
  return elements;
}

void GapSearch::record(const GapIncrement& increment, const std::optional<GapPose>& pose) {
  ++iterations;
  if (!pose) return;
  const double found = largest(contact_residual(elements_of(increment, *pose)));
  if (nearest && found >= violation) return;
  nearest = pose;
  violation = found;
}

std::optional<GapPose> switch_statuses(const GapIncrement& increment, std::vector<Trial> trial, GapSearch& search) {
  std::set<std::vector<Trial>> tried;
  while (!search.exhausted() && tried.insert(trial).second) {
    if (increment.target.normal_is_force && std::none_of(trial.begin(), trial.end(), touches)) {
      Eigen::Index nearest;  // a force needs someone to bear it
      increment.height.minCoeff(&nearest);
      trial[nearest] = increment.mu == 0 ? Trial::slip_plus : Trial::stick;
    }
    auto pose = pose_of(increment, trial);
    search.record(increment, pose);
    if (!pose) return std::nullopt;
    trial = next_trial(increment, *pose);
    if (trial == pose->trial) return pose;
  }
  return std::nullopt;
}

namespace {

bool meets_target(const GapIncrement& increment, const GapElements& elements, double tolerance) {
  const LoadStep& to = increment.target;
  const double scale = tolerance * elements.normal_force.sum();
  return (!to.normal_is_force || std::abs(elements.normal_force.sum() - to.normal) <= scale) &&
         (!to.tangential_is_force || std::abs(elements.tangential_force.sum() - to.tangential) <= scale);
}

/// The rubber without forces, the indenter at `depth`: a solution where nothing is penetrated. Other solutions, in
/// which friction wedges the rubber under an indenter that does not press, are left aside.
GapPose lifted_off(const GapIncrement& increment, double depth) {
  const LoadStep& to = increment.target;
  GapPose pose = undeformed(increment.system, increment.height);
  pose.depth = depth;
  pose.gap = increment.height.array() - depth;
  pose.tangential = to.tangential_is_force ? increment.previous.tangential : to.tangential;
  return pose;
}

std::optional<GapPose> search_pose(const GapIncrement& increment, GapSearch& search) {
  const LoadStep& to = increment.target;
  const double first_touch = increment.height.minCoeff();
  if (to.normal_is_force && to.normal == 0) return lifted_off(increment, first_touch);  // the depth is free
  if (!to.normal_is_force && to.normal <= first_touch) return lifted_off(increment, to.normal);
  if (auto pose = switch_statuses(increment, increment.previous.trial, search)) return pose;
  for (double offset_size : {1e-3, 1e3}) {
    const auto trial = follow_path(increment, search, offset_size);
    if (!trial) continue;
    if (auto pose = switch_statuses(increment, *trial, search)) return pose;
  }
  return std::nullopt;
}

}  // namespace

GapAnswer solve_increment(const GapIncrement& increment, int most_iterations, double tolerance) {
  GapSearch search{most_iterations};
  auto found = search_pose(increment, search);
  GapAnswer answer;
  answer.iterations = search.iterations;
  answer.pose = found ? *found : search.nearest ? *search.nearest : increment.previous;
  const GapElements elements = elements_of(increment, answer.pose);
  answer.residual = contact_residual(elements);
  answer.converged = found && largest(answer.residual) <= tolerance && meets_target(increment, elements, tolerance);
  return answer;
}

}  // namespace tactel::fem
