// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <limits>

namespace tactel::fem {

// The slip index of a pad, S = 1 / lambda: lambda is the largest factor by which the wrench (Q, M) can grow until the
// pressures given cannot bear it. The tractions |t_i| <= mu n_i that bear lambda (Q, M) are a convex problem, whose
// dual has two free unknowns:
//
//     lambda = min over twists (v, w) with v Q + w M = 1 of sum_i mu n_i |v + w e_z x r_i|
//
// S is |Q| / (mu P) where the line of Q runs through the pressure's centre of a symmetric contact, M / sum mu n_i |r_i|
// in pure torsion about that centre, and 1 where all cells slide as one rigid twist. It does not depend on the point to
// which M refers. Solved by reweighted least squares (E. Weiszfeld, Tohoku Math. J. 43, 1937, 355-386): with weights
// mu n_i / |slip_i| the minimum is one 3 x 3 solve; each round is an upper bound on lambda.

/// Rounds that leave 1e-10 of lambda; the kernel takes four, which leave 1e-3 at most.
inline constexpr int margin_rounds = 200;

/// `places` [cells][2] mm, `grip` [cells] N: mu n; `wrench`: Q, N, and M about the origin of places, N mm. Returns S; 0
/// for a wrench below 1e-6 of the grip.
double slip_margin(const Eigen::MatrixX2d& places, const Eigen::VectorXd& grip, const Eigen::Vector3d& wrench,
                   int rounds = margin_rounds);

}  // namespace tactel::fem
