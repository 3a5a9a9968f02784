#pragma once
#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/device/executor.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// Returns true where a patch serves the contact of this answer: the patch does not reach both ends of the sensor, and
/// lies within the range of the layer's tables. A mesh resolves wider contacts better.
bool patch_serves(const fem::Sensor& sensor, const fem::ContactSolution& answer);

/// Solves scenes as a rung models them. Contacts that a patch does not serve are solved on the rung's mesh, with the
/// load steps of the scene; such answers have no surface_width. `nodes`: also return forces and statuses of the gap
/// elements.
std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes = true);

}  // namespace tactel::host
