#pragma once
#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "fem/contact_solution.h"

namespace tactel::fem {

/// All gap elements at the end of an increment, as displacements and forces show them, whoever found these. The laws
/// they are held against: gap >= 0, n >= 0, gap n = 0 (Signorini); |t| <= mu n, slip only where |t| = mu n and against
/// t (Coulomb, in increments).
struct GapElements {
  double mu = 0;
  Eigen::VectorXd gap;  ///< [columns] mm, positive open; +infinity where there is no indenter
  Eigen::VectorXd
      slip;  ///< [columns] mm: increment of u_x minus that of the indenter, at touching and other nodes alike
  Eigen::VectorXd normal_force,
      tangential_force;                 ///< [columns] N/mm, of the indenter on the rubber; normal >= 0 presses
  Eigen::Vector2d base_force = {0, 0};  ///< N/mm: sum of the rubber's forces on the base, x and y
  double largest_displacement = 0;      ///< mm, of the surface nodes
};

/// Friction that counts as unlimited ("bonded"): what touches sticks until it lifts off. Solvers put this in infinity's
/// place, for infinity times a pressure of 0 is no number.
inline constexpr double largest_friction = 1e15;

/// S = Q / (mu P); none where mu P = 0, 0 where friction is unlimited.
std::optional<double> slip_index(double mu, double P, double Q);

/// What counts as rounding of a force, of (1 + mu) times the largest normal force: a node this close to |t| = mu n
/// slips, and the friction of a node that bears less shows no direction. In fp64 rounding is 1e-12 at nu = 0.4999; load
/// increments do far more than 1e-10.
inline constexpr double force_rounding = 1e-10;

/// Open where n = 0; slip where |t| reaches mu n (always, if mu = 0); stick elsewhere. [columns]
std::vector<GapStatus> gap_status(const GapElements& elements, double rounding = force_rounding);

/// How far the elements are from the laws: definitions in contact_solution.h. A quantity that is not 0 while its scale
/// is, counts as the largest double, and so does all where anything is NaN.
Residual contact_residual(const GapElements& elements, double rounding = force_rounding);

/// The largest of a residual's members.
double largest(const Residual& residual);

}  // namespace tactel::fem
