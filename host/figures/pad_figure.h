// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_solver.h"
#include "host/figures/plot.h"

namespace tactel::host {

/// Returns the figure of a contact on a pad at one of its steps: pressure, shear and status of the cells from above,
/// stress at the tactels, a cut along the indenter's own x, and the grip along the path.
Figure contact_figure(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t step);

}  // namespace tactel::host
