// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/layer/sensor_family.h"
#include "fem/scene.h"
#include "host/contact/gap_sweep.h"
#include "host/contact/patch_contact.h"
#include "host/device/executor.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// Returns the launcher's options of a rung on patches, and those of its mesh.
PatchContactOptions patch_options(const Rung& rung);
GapSweepOptions mesh_options(const Rung& rung, bool nodes);

/// Returns the scene as a rung on meshes models it, with each of its pressing steps in `parts` increments.
struct MeshedScene {
  fem::Scene scene;
  int parts = 1;
};
MeshedScene meshed_with_own_steps(const fem::Scene& scene, const Rung& rung);

/// Replaces the answers that a patch does not solve by those of the rung's mesh: the second part of solve_on_rung.
void finish_on_mesh(const GapSweepSolver& mesh, std::span<const fem::Scene> scenes, const Rung& rung,
                    std::vector<fem::ContactSolution>& answers);
/// Returns the solver of a rung's meshes. `nodes`, `force_error`: as GapSweepOptions.
GapSweepSolver mesh_solver(Executor& executor, const Rung& rung, bool nodes, bool force_error = true);

/// Solves scenes as a rung models them. Contacts that are not solved on a patch are solved on the rung's mesh, with the
/// load steps of the scene; such answers have no surface_width. `nodes`: also return
/// forces and statuses of the gap elements.
std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes = true);

/// Makes tables 0 ... count - 1 on all threads, and tells the device's log how many are made.
void make_tables(Executor& executor, std::size_t count, const std::function<void(std::size_t)>& make);

/// Returns the tables of all sensors of a range, made on all threads.
fem::SensorFamily sensor_family(Executor& executor, const fem::SensorRange& range, bool sides = true);

/// Solves scenes on sensors of this family on a rung with patches, as sets of such sensors do. The reference takes
/// exact tables of each sensor.
std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, const fem::SensorFamily& family,
                                                std::span<const fem::Scene> scenes, const Rung& rung);

}  // namespace tactel::host
