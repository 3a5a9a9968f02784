// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/contact_solution.h"
#include "fem/pad/pad_solver.h"
#include "fem/scenes/scene.h"
#include "host/figures/plot.h"

namespace tactel::host {

/// Returns the figure of a solved contact at one of its steps: tractions on the surface with stick and slip
/// marked, stress at the tactels, and the slippage index along the path.
Figure contact_figure(const fem::Scene& scene, const fem::ContactSolution& solution, std::size_t step);
/// Returns the figure of a contact on a pad at one of its steps: pressure, shear and status of the cells from above,
/// stress at the tactels, a cut along the indenter's own x, and the grip along the path.
Figure contact_figure(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t step);

/// Returns nodal forces [columns] N/mm as tractions, MPa. Each node owns half of the distance to its neighbours.
std::vector<double> traction(const Eigen::VectorXd& force, const Eigen::VectorXd& x);

/// Returns the share of the touching nodes that stick; NaN where none touches.
double sticking_share(const fem::ContactStep& step);

/// Returns the step that tells most of a path: the last in which some nodes stick and some slip, else the last.
std::size_t telling_step(const fem::ContactSolution& solution);

}  // namespace tactel::host
