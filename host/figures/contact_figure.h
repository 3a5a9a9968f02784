// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

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

/// Returns forces [surface] N/mm as tractions, MPa: of a patch over the widths of its elements, of a mesh over half of
/// the distances of each node to its neighbours.
Eigen::VectorXd traction_of(const Eigen::VectorXd& force, const fem::ContactSolution& solution);

/// Returns the touched part of the surface at a step, mm; from infinity to -infinity where nothing is.
fem::Interval touched_part(const fem::ContactSolution& solution, const fem::ContactStep& step);

/// Returns the share of the touching nodes or cells that stick; NaN where none touches.
double sticking_share(const fem::ContactStep& step);
inline double sticking_share(const fem::PadStep& step) { return step.P > 0 ? step.stick_fraction : NAN; }

/// Returns the step that tells most of a path: the last in which some nodes or cells stick and some slip, else the
/// last.
std::size_t telling_step(const auto& solution) {
  for (std::size_t k = solution.steps.size(); k-- > 0;)
    if (const double share = sticking_share(solution.steps[k]); share > 0 && share < 1) return k;
  return solution.steps.size() - 1;
}

/// Returns the points x, y of the nodes or cells of one status, with its mark.
Series marked(const std::vector<fem::GapStatus>& statuses, const Eigen::VectorXd& x, const Eigen::VectorXd& y,
              fem::GapStatus status);

/// Returns share(step) of each step.
Series along_path(const auto& steps, const char* label, Ink ink, Mark mark, const auto& share) {
  Series out{.label = label, .mark = mark, .ink = ink};
  for (const auto& step : steps) out.x.push_back(static_cast<double>(out.x.size() + 1)), out.y.push_back(share(step));
  return out;
}
/// Returns a panel of these, with a line at the step that is shown.
Panel path_panel(std::vector<Series> shares, std::size_t shown);

}  // namespace tactel::host
