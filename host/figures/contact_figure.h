#pragma once
#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/figures/plot.h"

namespace tactel::host {

/// Returns the figure of a solved contact at one of its steps: tractions on the surface with stick and slip
/// marked, stress at the tactels, and the slippage index along the path.
Figure contact_figure(const fem::Scene& scene, const fem::ContactSolution& solution, std::size_t step);

/// Returns nodal forces [columns] N/mm as tractions, MPa. Each node owns half of the distance to its neighbours.
std::vector<double> traction(const Eigen::VectorXd& force, const Eigen::VectorXd& x);

/// Returns the base stress along the path as two heat strips (sigma_y, tau_xy): one row a step, one column a
/// tactel.
Figure base_strips(const fem::ContactSolution& solution, const std::string& title);

/// Returns the status of the surface nodes (open, stick or slip): one row a step.
Panel status_strip(const fem::ContactSolution& solution, const std::string& title);

}  // namespace tactel::host
