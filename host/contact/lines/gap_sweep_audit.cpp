// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/gap_sweep_audit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/gap/contact_laws.h"

namespace tactel::host {
namespace {

/// Forces within this share of (1 + mu) times the largest are equal in fp32: |t| = fl(mu n) must count as slip.
constexpr double equal_forces = 8 * std::numeric_limits<float>::epsilon();

/// [2 columns] N/mm, as fem::Condensation takes it.
Eigen::VectorXd surface_load(const fem::ContactStep& step) {
  Eigen::VectorXd load(2 * step.normal_force.size());
  load(Eigen::seq(0, Eigen::last, 2)) = step.tangential_force;
  load(Eigen::seq(1, Eigen::last, 2)) = -step.normal_force;
  return load;
}

/// Follows an answer's displacements step by step.
class Audit {
 public:
  Audit(const fem::Scene& scene, const fem::Condensation& condensation)
      : scene_(scene),
        condensation_(condensation),
        height_(fem::profile_heights(scene.indenter, condensation.surface_x)),
        last_ux_(Eigen::VectorXd::Zero(height_.size())),
        held_ux_(last_ux_) {}

  void take(const fem::ContactStep& step) {
    const Eigen::VectorXd u = condensation_.compliance * surface_load(step) / scene_.sensor.young;
    const Eigen::VectorXd ux = u(Eigen::seq(0, Eigen::last, 2)), uy = u(Eigen::seq(1, Eigen::last, 2));
    const double moved = step.tangential - last_tangential_;
    elements_ = {std::min(scene_.friction, fem::largest_friction),
                 height_.array() - step.indentation - uy.array(),
                 ux.array() - last_ux_.array() - moved,
                 step.normal_force,
                 step.tangential_force,
                 {step.base_force_x.sum(), step.base_force_y.sum()},
                 uy.cwiseAbs().maxCoeff()};
    slip_since_stick_ = ux.array() - held_ux_.array() - moved;
    for (Eigen::Index i = 0; i < ux.size(); ++i)
      held_ux_[i] = step.status[i] == fem::GapStatus::stick ? held_ux_[i] + moved : ux[i];
    last_ux_ = ux;
    last_tangential_ = step.tangential;
  }

  /// With slip in the increment alone, and since nodes began to stick: the larger drift of both.
  fem::Residual residual() {
    fem::Residual found = fem::contact_residual(elements_, equal_forces);
    std::swap(elements_.slip, slip_since_stick_);
    found.drift = std::max(found.drift, fem::contact_residual(elements_, equal_forces).drift);
    std::swap(elements_.slip, slip_since_stick_);
    return found;
  }

  const Eigen::VectorXd& gap() const { return elements_.gap; }                   ///< [columns] mm
  const Eigen::VectorXd& slip_since_stick() const { return slip_since_stick_; }  ///< [columns] mm

 private:
  const fem::Scene& scene_;
  const fem::Condensation& condensation_;
  Eigen::VectorXd height_;             ///< [columns] mm
  Eigen::VectorXd last_ux_, held_ux_;  ///< [columns] mm: at the last increment; there, where sticking nodes should be
  Eigen::VectorXd slip_since_stick_;
  double last_tangential_ = 0;
  fem::GapElements elements_;
};

/// The larger figure of both; NaN stays.
void keep_larger(fem::Residual& said, const fem::Residual& found) {
  for (const auto member : {&fem::Residual::penetration, &fem::Residual::cone, &fem::Residual::complementarity,
                            &fem::Residual::drift, &fem::Residual::balance})
    if (said.*member < found.*member) said.*member = found.*member;
}

/// Surface load that closes the gaps of touching nodes and takes back the slip of sticking ones, N/mm.
Eigen::VectorXd correction(const Audit& audit, const fem::Scene& scene, const fem::Condensation& condensation,
                           const fem::ContactStep& step) {
  std::vector<int> unknowns;
  std::vector<double> wanted;  // mm
  for (Eigen::Index i = 0; i < audit.gap().size(); ++i) {
    const int x = static_cast<int>(2 * i);
    if (step.status[i] == fem::GapStatus::stick) {
      unknowns.push_back(x);
      wanted.push_back(-audit.slip_since_stick()[i]);
    }
    if (step.status[i] == fem::GapStatus::open) continue;
    unknowns.push_back(x + 1);
    wanted.push_back(audit.gap()[i]);
  }
  Eigen::VectorXd load = Eigen::VectorXd::Zero(condensation.compliance.cols());
  if (unknowns.empty()) return load;
  const Eigen::MatrixXd between = condensation.compliance(unknowns, unknowns);
  const Eigen::Map<const Eigen::VectorXd> displacement(wanted.data(), static_cast<Eigen::Index>(wanted.size()));
  load(unknowns) = between.ldlt().solve(displacement) * scene.sensor.young;
  return load;
}

}  // namespace

void audit_in_fp64(const fem::Scene& scene, const fem::Condensation& condensation, double accept,
                   fem::ContactSolution& solution) {
  Audit audit(scene, condensation);
  bool solved = true;
  for (fem::ContactStep& step : solution.steps) {
    audit.take(step);
    keep_larger(step.residual, audit.residual());
    solved = solved && step.converged && fem::largest(step.residual) <= accept;
    step.converged = solved;
  }
}

double base_force_error(const fem::Scene& scene, const fem::Condensation& condensation,
                        const fem::ContactSolution& solution) {
  Audit audit(scene, condensation);
  double largest = 0;
  for (const fem::ContactStep& step : solution.steps) {
    audit.take(step);
    const double off = (condensation.base_force * correction(audit, scene, condensation, step)).cwiseAbs().maxCoeff();
    const double scale = std::max(step.base_force_x.cwiseAbs().maxCoeff(), step.base_force_y.cwiseAbs().maxCoeff());
    if (scale > 0) largest = std::max(largest, off / scale);
  }
  return largest;
}

}  // namespace tactel::host
