#pragma once
#include <functional>

#include "fem/contact_solution.h"
#include "fem/gap_increment.h"
#include "fem/scene.h"

namespace tactel::fem {

struct GapReferenceOptions {
  int most_iterations = 2000;  ///< linear solves an increment may take, safeguards included; a few do nearly always
  double tolerance = 1e-10;    ///< largest relative residual that counts as converged
};

/// sigma_y, then tau_xy [2 tactels] MPa, of a state of the system and its base forces [2 base nodes] N/mm.
using TactelStress = std::function<Eigen::VectorXd(const Extended& state, const Eigen::VectorXd& base_force)>;

/// Solves the increments of the scene's load path one after the other. `positions`: an empty solution with the places
/// of nodes and tactels.
ContactSolution walk_load_path(GapSystem& system, const Scene& scene, ContactSolution positions,
                               const GapReferenceOptions& options, const TactelStress& stress);

}  // namespace tactel::fem
