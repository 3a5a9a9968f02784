// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/layer/patch_force_control.h"
#include "fem/layer/patch_path.h"
#include "fem/layer/rigid_contact.h"
#include "fem/mesh/block.h"

namespace tactel::fem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most_force_trials = 60;

/// Profile heights at the elements and beyond, [elements + 2 rows_beyond] mm; +infinity beyond the sensor.
Eigen::VectorXd patch_heights(const Patch& patch, const Scene& scene) {
  Eigen::VectorXd x(patch.elements + 2 * rows_beyond);
  for (int i = 0; i < x.size(); ++i) x[i] = patch.place(i - rows_beyond);
  Eigen::VectorXd height = profile_heights(scene.indenter, x);
  for (int i = 0; i < x.size(); ++i)
    if (std::abs(x[i]) > scene.sensor.length / 2) height[i] = infinity;
  return height;
}

/// How many elements beyond either end are penetrated.
struct Beyond {
  int left = 0, right = 0;
  void look(const GapElements& e, double accept) {
    const double most = accept * e.largest_displacement;
    const Eigen::Index last = e.gap.size() - 1;
    for (int k = 1; k <= rows_beyond; ++k) {
      if (e.gap[rows_beyond - k] < -most) left = std::max(left, k);
      if (e.gap[last - rows_beyond + k] < -most) right = std::max(right, k);
    }
  }
  bool any() const { return left > 0 || right > 0; }
};

/// How much of the last change of the forces to expect again: 0 where both targets change, or the way turns, or the
/// load is a force.
double expected_ratio(const Eigen::Vector2d& change, const Eigen::Vector2d& last) {
  double ratio = 0;
  if (change[0] == 0 && last[0] == 0 && last[1] != 0)
    ratio = change[1] / last[1];
  else if (change[1] == 0 && last[1] == 0 && last[0] != 0)
    ratio = change[0] / last[0];
  return ratio > 0 && ratio <= 2 ? ratio : 0;
}

PatchOptions of_sweeps(PatchOptions options, const Scene& scene) {
  if (by_force(scene)) options.tolerance /= 10;
  return options;
}

/// A scene on its way along the load path, on one patch.
class PatchWalk {
 public:
  PatchWalk(const LayerModel& model, const PatchOptions& options, const Patch& patch, const Scene& scene)
      : options_(options),
        scene_(scene),
        x_(places(patch)),
        width_(patch.width()),
        compliance_(patch_compliance(model, patch)),
        contact_(compliance_, patch_heights(patch, scene), std::min(scene.friction, largest_friction),
                 of_sweeps(options, scene)),
        force_(contact_.first_touch()),
        base_(model.base) {}

  ContactSolution walk(Beyond& beyond);

 private:
  void move_to(const LoadStep& target);
  bool reach_forces(bool solved);
  ContactStep step_here(Beyond& beyond) const;

  Eigen::Vector2d last_change_ = {0, 0};  ///< of depth and x in the increment before, mm
  const PatchOptions& options_;
  const Scene& scene_;
  Eigen::VectorXd x_;
  double width_;  ///< of an element, mm
  PatchCompliance compliance_;
  PatchContact contact_;
  PatchForceControl force_;
  const BaseStressTable& base_;
  bool converged_ = true;  ///< this increment and all before it
  int sweeps_ = 0;         ///< since the last asked step
};

/// One increment, as kernels/gap_sweep.cl makes it: rest where nothing moves, else a guess, sweeps, and the search for
/// given forces.
void PatchWalk::move_to(const LoadStep& target) {
  const double young = scene_.sensor.young;
  const LoadStep scaled{target.normal_is_force, target.tangential_is_force,
                        target.normal_is_force ? target.normal / young : target.normal,
                        target.tangential_is_force ? target.tangential / young : target.tangential};
  const double depth = target.normal_is_force ? force_.start(scaled, contact_.depth) : target.normal;
  const double x = target.tangential_is_force ? contact_.x : target.tangential;
  const Eigen::Vector2d change(depth - contact_.depth, x - contact_.x);
  const double ratio = target.normal_is_force ? 0 : expected_ratio(change, last_change_);
  last_change_ = change;
  contact_.depth = depth;
  contact_.x = x;
  const bool held = change[0] == 0 && (change[1] == 0 || scene_.friction == 0);  // without friction only depth counts
  bool solved = true;
  if (held) {
    contact_.hold();
  } else {
    contact_.extrapolate(ratio);
    if (target.normal_is_force ? !(target.normal > 0) : depth <= contact_.first_touch()) contact_.release();
    solved = contact_.solve(sweeps_);
  }
  if (target.normal_is_force && target.normal > 0) solved = reach_forces(solved);
  converged_ &= solved;
}

/// Of the trials, the last one's sweeps count.
bool PatchWalk::reach_forces(bool solved) {
  for (int trial = 0; trial < most_force_trials; ++trial) {
    const double P = contact_.n().sum(), Q = contact_.t().sum();
    if (!force_.move(P, Q, std::min(scene_.friction, largest_friction), options_.tolerance, contact_.depth, contact_.x))
      return solved;
    solved = contact_.solve(sweeps_);
  }
  return false;
}

ContactStep PatchWalk::step_here(Beyond& beyond) const {
  const double young = scene_.sensor.young;
  const GapElements e = contact_.elements();
  beyond.look(e, options_.accepted());
  ContactStep step;
  step.indentation = contact_.depth;
  step.tangential = contact_.x;
  step.normal_force = contact_.n() * young;
  step.tangential_force = contact_.t() * young;
  step.P = step.normal_force.sum();
  step.Q = step.tangential_force.sum();
  step.slip_index = slip_index(scene_.friction, step.P, step.Q);
  step.base_force_x = Eigen::VectorXd::Constant(1, step.Q);
  step.base_force_y = Eigen::VectorXd::Constant(1, -step.P);
  const std::vector<GapStatus> status = gap_status(e);
  step.status.assign(status.begin() + rows_beyond, status.end() - rows_beyond);
  const Eigen::VectorXd ux = contact_.ux();
  for (Eigen::Index i = 0; i < ux.size(); ++i)
    if (step.normal_force[i] > 0) step.slip_distance = std::max(step.slip_distance, std::abs(contact_.x - ux[i]));
  const Eigen::VectorXd stress = base_.stress(x_, step.normal_force, step.tangential_force);
  step.sigma_y = stress.head(stress.size() / 2);
  step.tau_xy = stress.tail(stress.size() / 2);
  step.residual = contact_residual(e);
  step.converged = converged_ && largest(step.residual) <= options_.accepted();
  step.iterations = sweeps_;
  return step;
}

bool slides(const ContactStep& step) {
  const auto count = [&](GapStatus status) { return std::count(step.status.begin(), step.status.end(), status); };
  return count(GapStatus::slip) > 0 && count(GapStatus::stick) == 0;
}

ContactSolution PatchWalk::walk(Beyond& beyond) {
  ContactSolution solution;
  solution.surface_x = x_;
  solution.surface_width = Eigen::VectorXd::Constant(x_.size(), width_);
  solution.base_x = Eigen::VectorXd::Zero(1);
  solution.tactel_x = tactel_positions(scene_.sensor);
  const LoadPath path = load_path(scene_.load);
  for (const PatchStep& increment : patch_steps(path, scene_.load, options_.increments())) {
    move_to(increment.target);
    if (increment.asked) {
      solution.steps.push_back(step_here(beyond));
      converged_ = solution.steps.back().converged;
      sweeps_ = 0;
      const bool tangential = static_cast<int>(solution.steps.size()) > path.indentation_steps;
      solution.sliding = tangential && slides(solution.steps.back());
      if (path.until_sliding && solution.sliding) break;
    }
    contact_.remember();
  }
  return solution;
}

}  // namespace

Patch grown(const Patch& patch, int beyond_left, int beyond_right, const PatchLimits& limits) {
  const double d = patch.width();
  const auto more = [&](int elements) { return elements > 0 ? (elements + 0.5) * d : 0; };
  // An end that overhangs the indenter's edge goes back to the edge before make_patch takes it beyond again.
  return make_patch({patch.left - more(beyond_left), patch.right + more(beyond_right)}, limits, patch.elements);
}

PatchSolver::PatchSolver(const LayerModel& model, const PatchOptions& options) : model_(model), options_(options) {}

ContactSolution PatchSolver::solve_on(const Patch& patch, const Scene& scene) const {
  scene.validate();
  require_sensor_of(model_, scene.sensor);
  Beyond beyond;
  return PatchWalk(model_, options_, patch, scene).walk(beyond);
}

ContactSolution PatchSolver::solve(const Scene& scene, Patch* last) const {
  scene.validate();
  require_sensor_of(model_, scene.sensor);
  Scene hulled = scene;
  hulled.indenter = with_hull(scene.indenter);
  Patch patch = find_patch(hulled, model_.table, options_.elements).patch;
  const PatchLimits limits = patch_limits(hulled);
  for (int growths = 0;; ++growths) {
    Beyond beyond;
    if (last) *last = patch;
    ContactSolution solution = PatchWalk(model_, options_, patch, hulled).walk(beyond);
    if (!beyond.any() || growths == options_.most_growths) return solution;
    patch = grown(patch, beyond.left, beyond.right, limits);
  }
}

}  // namespace tactel::fem
