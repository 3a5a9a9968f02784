// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "fem/gap/contact_solution.h"

namespace tactel::fem {

/// State of all gap elements at the end of an increment, from displacements and forces, independent of the
/// solver. The laws are gap >= 0, n >= 0, gap n = 0 (Signorini), and |t| <= mu n, slip only where |t| = mu n and
/// against t (Coulomb, in increments).
struct GapElements {
  double mu = 0;
  Eigen::VectorXd gap;  ///< [columns] mm, positive open; +infinity beyond the indenter
  Eigen::VectorXd
      slip;  ///< [columns] mm: increment of u_x minus that of the indenter, at touching and other nodes alike
  Eigen::VectorXd normal_force,
      tangential_force;                 ///< [columns] N/mm, of the indenter on the rubber; normal >= 0 presses
  Eigen::Vector2d base_force = {0, 0};  ///< N/mm: sum of the rubber's forces on the base, x and y
  double largest_displacement = 0;      ///< mm, of the surface nodes
};

/// Friction that counts as unlimited ("bonded"): touching nodes stick until they lift off. Solvers use this value
/// instead of infinity. Forces depend on 1/mu there, so P and Q are within a few 1e-6 of their limits. A larger
/// value would leave mu n, at a node that is about to lift off, to rounding.
inline constexpr double largest_friction = 1e6;

/// Returns S = Q / (mu P); none where mu P = 0, and 0 where friction is unlimited.
inline std::optional<double> slip_index(double mu, double P, double Q) {
  if (!(mu * P > 0)) return std::nullopt;
  return mu < largest_friction ? Q / (mu * P) : 0;
}

/// Rounding of a force, relative to (1 + mu) times the largest normal force. A node this close to |t| = mu n
/// slips; the friction of a node that bears less has no direction. Rounding in fp64 is 1e-12 at nu = 0.4999; load
/// increments cause far more than 1e-10.
inline constexpr double force_rounding = 1e-10;

/// Rounding of a normal force in an exact solution, relative to the largest one. At unlimited friction, mu times it is
/// all that the cone is known to: the residual counts what exceeds it.
inline constexpr double solved_rounding = 1e-13;

/// Returns the contact status [columns]: open where n = 0, slip where |t| reaches mu n (always, if mu = 0), stick
/// elsewhere.
std::vector<GapStatus> gap_status(const GapElements& elements, double rounding = force_rounding);

/// Returns the residual of the laws; contact_solution.h defines its members. A quantity that is not 0 while its
/// scale is 0 counts as the largest double. A NaN anywhere makes all members the largest double.
Residual contact_residual(const GapElements& elements, double rounding = force_rounding);

/// Returns the largest member of a residual.
double largest(const Residual& residual);

}  // namespace tactel::fem
