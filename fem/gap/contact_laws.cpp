// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/contact_laws.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactel::fem {
namespace {

constexpr double worst = std::numeric_limits<double>::max();

double relative(double value, double scale) {
  if (value == 0) return 0;
  const double ratio = value / scale;
  return ratio < worst ? ratio : worst;
}

double largest_normal(const GapElements& e) { return std::max(0.0, e.normal_force.maxCoeff()); }

// std::max would pass over a NaN.
bool all_numbers(const GapElements& e) {
  return e.slip.allFinite() && e.normal_force.allFinite() && e.tangential_force.allFinite() &&
         e.base_force.allFinite() && std::isfinite(e.largest_displacement) && !e.gap.array().isNaN().any();
}

// Slip that the laws forbid at a node that bears `n` > 0, mm.
double forbidden_slip(const GapElements& e, Eigen::Index i, GapStatus status) {
  if (status == GapStatus::stick) return std::abs(e.slip[i]);
  const double along = e.tangential_force[i] > 0 ? e.slip[i] : -e.slip[i];
  return std::max(0.0, along);
}

}  // namespace

std::vector<GapStatus> gap_status(const GapElements& e, double rounding) {
  const double allowance = rounding * (1 + e.mu) * largest_normal(e);
  std::vector<GapStatus> status(e.gap.size(), GapStatus::open);
  for (Eigen::Index i = 0; i < e.gap.size(); ++i) {
    if (!(e.normal_force[i] > 0)) continue;
    const double reserve = e.mu * e.normal_force[i] - std::abs(e.tangential_force[i]);
    status[i] = reserve <= allowance ? GapStatus::slip : GapStatus::stick;
  }
  return status;
}

Residual contact_residual(const GapElements& e, double rounding) {
  if (!all_numbers(e)) return {worst, worst, worst, worst, worst};
  const std::vector<GapStatus> status = gap_status(e, rounding);
  const double normal = largest_normal(e), displacement = e.largest_displacement;
  const double bonded_rounding = e.mu < largest_friction ? 0 : solved_rounding * e.mu * normal;
  double penetration = 0, cone = 0, complementarity = 0, drift = 0;
  for (Eigen::Index i = 0; i < e.gap.size(); ++i) {
    const double n = e.normal_force[i];
    penetration = std::max(penetration, -e.gap[i]);
    cone = std::max({cone, std::abs(e.tangential_force[i]) - e.mu * n - bonded_rounding, -n});
    if (n > 0) complementarity = std::max(complementarity, std::abs(e.gap[i]));
    if (e.mu > 0 && n > rounding * normal) drift = std::max(drift, forbidden_slip(e, i, status[i]));
  }
  // The rubber passes on to the base what the indenter does to it.
  const Eigen::Vector2d surface(e.tangential_force.sum(), -e.normal_force.sum());
  const double balance = (e.base_force - surface).norm(), force = std::max(e.base_force.norm(), surface.norm());
  return {relative(penetration, displacement), relative(cone, normal), relative(complementarity, displacement),
          relative(drift, displacement), relative(balance, force)};
}

double largest(const Residual& r) { return std::max({r.penetration, r.cone, r.complementarity, r.drift, r.balance}); }

}  // namespace tactel::fem
