// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fem/pad/pad_solver.h"
#include "host/figures/view_parts.h"

namespace tactel::host {

/// Returns the view of a contact on a pad: tractions and status of the cells, stress at the tactels, the indenter's
/// outline, and forces along the path (host/figures/page/pad.js). Tractions are those of the indenter on the rubber. Of
/// a long path only some steps are shown (shown_steps).
ContactView contact_view(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t shown);

/// Returns the outline of the part of an indenter that lies below the undeformed surface at a depth, [points][2] mm in
/// the indenter's own frame, counter-clockwise, as seen from its middle. Empty where the depth is not above 0.
Eigen::MatrixX2d section_outline(const fem::PadIndenter& indenter, double depth);

/// Returns places [n][2] of the indenter's own frame on the pad, mm.
Eigen::MatrixX2d on_pad(const fem::PadIndenter& indenter, const Eigen::MatrixX2d& own);

/// Returns the corners of the cells on the pad, [n + 1][n + 1] mm, in their order.
Eigen::MatrixX2d cell_corners(const fem::PadIndenter& indenter, const fem::PadCells& cells);

/// Returns the corners of each cell among those, counter-clockwise, [cells][4].
Eigen::MatrixXi corners_of_cells(int n);

/// Returns the step that tells most of a path: the last in which some cells stick and some slip, else the last.
std::size_t telling_step(const fem::PadSolution& solution);

}  // namespace tactel::host
