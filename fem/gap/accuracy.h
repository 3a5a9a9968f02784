// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <limits>

namespace tactel::fem {

/// How exactly sweeps solve a contact. They end where no force changes by more than `tolerance` of the largest pressure
/// force. A step is solved where its largest residual is at most `accept`. Sweeps that contract by q leave 1 / (1 - q)
/// times their last change: the slowness, 20 on a patch, 100 on a mesh. Every solver, rung and command has, unless an
/// accepted residual is requested,
///     tolerance <= largest_tolerance < largest_accept,
///     accept = min(slowness tolerance, largest_accept), and 200 epsilon at least, which rounding may leave.
/// A requested residual is accepted itself, and tolerance = accept / slowness.
struct Accuracy {
  double tolerance = 0;  ///< 0: of the accepted residual
  double accept = 0;     ///< 0: of the tolerance
};

inline constexpr double slow_on_patch = 20, slow_on_mesh = 100;
template <class Real>
inline constexpr double largest_tolerance = sizeof(Real) == 4 ? 1e-2 : 1e-7;
template <class Real>
inline constexpr double largest_accept = sizeof(Real) == 4 ? 0.02 : 1e-6;

/// Returns both numbers, by the rule.
template <class Real>
Accuracy by_rule(const Accuracy& given, double slowness) {
  if (given.accept > 0) return {given.tolerance > 0 ? given.tolerance : given.accept / slowness, given.accept};
  const double tolerance = std::min(given.tolerance, largest_tolerance<Real>);
  const double rounding = 200.0 * std::numeric_limits<Real>::epsilon();
  return {tolerance, std::max(std::min(slowness * tolerance, largest_accept<Real>), rounding)};
}

/// Returns the tolerance of a contact's sweeps: S has mu P below it, and so with little friction what sweeps leave is
/// to be small beside mu.
inline double sweep_tolerance(double tolerance, double mu) {
  constexpr double little_friction = 0.01, least = 1e-5;
  if (mu == 0 || mu >= little_friction) return tolerance;
  return std::max(tolerance * mu / little_friction, std::min(tolerance, least));
}

}  // namespace tactel::fem
