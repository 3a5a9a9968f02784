// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/layer/sensor_family.h"
#include "fem/scenes/scene.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/device/executor.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// Solves scenes as a rung models them: contacts that no patch solves on the rung's mesh, with the load steps of the
/// scene. `nodes`: of meshes, return also forces and statuses of the gap elements. `family`: of the sensors, as sets
/// have them where each contact has its own; the reference takes exact tables of each sensor.
std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes = true,
                                                std::shared_ptr<const fem::SensorFamily> family = {});

/// Solves scenes on the meshes of their sensors.
std::vector<fem::ContactSolution> solve_on_meshes(Executor& executor, std::span<const fem::Scene> scenes,
                                                  Precision precision, const GapSweepOptions& options = {});

}  // namespace tactel::host
