// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "fem/gap/contact_solution.h"
#include "fem/gap/gap_increment.h"
#include "fem/scenes/scene.h"

namespace tactel::fem {

struct GapReferenceOptions {
  int most_iterations = 2000;  ///< most linear solves of an increment, safeguards included; usually a few
  double tolerance = 1e-10;    ///< largest relative residual that counts as converged
};

/// Returns sigma_y, then tau_xy [2 tactels] MPa, of a state of the system and its base forces [2 base nodes]
/// N/mm.
using TactelStress = std::function<Eigen::VectorXd(const Extended& state, const Eigen::VectorXd& base_force)>;

/// Load stepping: solves the increments of the scene's load path in order. `positions` is an empty solution with
/// the positions of nodes and tactels.
ContactSolution step_load_path(GapSystem& system, const Scene& scene, ContactSolution positions,
                               const GapReferenceOptions& options, const TactelStress& stress);

/// Returns the number of equal parts of each pressing step with which every target takes at least `increments`.
int pressing_parts(const Load& load, int increments);

/// Keeps of a solution whose pressing steps were divided into `parts` the steps that the load itself has.
void keep_own_steps(ContactSolution& solution, const Load& load, int parts);

}  // namespace tactel::fem
