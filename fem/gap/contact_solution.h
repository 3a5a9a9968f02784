// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <vector>

namespace tactel::fem {

enum class GapStatus : std::uint8_t { open, stick, slip };

/// Residual of the contact laws in a step, from the final forces alone; all members are relative.
struct Residual {
  double penetration = 0;      ///< largest penetration over the largest surface displacement
  double cone = 0;             ///< largest |t| - mu n, over the largest n (0 if none)
  double complementarity = 0;  ///< largest |gap| at a node with n > 0, over the largest surface displacement
  double drift = 0;  ///< largest slip of a sticking node, or slip along (not against) friction, over the largest
                     ///< surface displacement. Slip counts from the increment before. In batched answers it counts also
                     ///< from where a node began to stick, and the larger one is taken, so that errors of many
                     ///< increments do not add up unseen. The kernel's own figure, which sets hold, is the second alone
  double balance = 0;  ///< |base force + surface force| over the largest of both
};

/// The state at the end of a load increment. Forces are those of the indenter on the rubber, except base_force
/// (rubber on base).
struct ContactStep {
  double indentation = 0, tangential = 0;          ///< mm, position of the indenter
  double P = 0, Q = 0;                             ///< N/mm, P >= 0; Q > 0 drags the rubber to +x
  std::optional<double> slip_index;                ///< S = Q / (mu P); none when mu P = 0
  double slip_distance = 0;                        ///< mm: largest |tangential - u_x| of a node that touches: how far
                                                   ///< the indenter has slid over the rubber since first touch
  std::vector<GapStatus> status;                   ///< [columns]
  Eigen::VectorXd normal_force, tangential_force;  ///< [columns] N/mm; normal >= 0 presses
  Eigen::VectorXd base_force_x, base_force_y;      ///< [base nodes] N/mm
  Eigen::VectorXd sigma_y, tau_xy;                 ///< [tactels] MPa
  bool converged = false;                          ///< and so are all steps before it
  int iterations = 0;
  Residual residual;
};

/// Least number of elements of a patch that a contact must cover: of parabolas, wedges and rounded flats on them P is
/// off by 11 % at most at 4 elements, by up to 70 % at 2.
inline constexpr int least_elements = 4;

struct ContactSolution {
  Eigen::VectorXd surface_x, base_x, tactel_x;  ///< mm
  std::vector<ContactStep> steps;
  bool sliding = false;         ///< the last step slides as a whole
  bool fell_back = false;       ///< the chosen solver failed; the exact fallback answered
  bool several = false;         ///< another certified solution is known: Coulomb's law does not determine this contact
  double base_force_error = 0;  ///< in fp32: estimate of the error of single base forces over the largest; 0: none made
  Eigen::VectorXd surface_width{};  ///< [elements] mm, of the elements of a patch (fem/layer); empty on a mesh
  bool linear_elements = false;     ///< of a patch: with linear pressures (fem/layer/linear_elements.h)
};

}  // namespace tactel::fem
