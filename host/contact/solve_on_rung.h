#pragma once
#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/device/executor.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// Solves scenes as a rung models them (on_rung). `nodes`: also return forces and statuses of the gap elements.
std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes = true);

}  // namespace tactel::host
