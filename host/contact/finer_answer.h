// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <future>
#include <optional>

#include "host/contact/solve.h"

namespace tactel::host {

/// The answer of a scene's finer model. Begun before the scene is solved, it takes the time of another core.
using FinerAnswer = std::future<fem::ContactSolution>;

/// Begins to solve a scene on a mesh with half the element size, in a thread of its own. Returns a future without a
/// state where mesh_error would not solve it, or where the load path depends on the scene's own answer.
FinerAnswer begin_finer(const fem::Scene& scene);

/// As mesh_error without `finer`, which is of begin_finer.
std::optional<MeshError> mesh_error(const fem::Scene& scene, const fem::ContactSolution& answer, FinerAnswer finer);
std::optional<MeshError> mesh_error(const SolveOutcome& outcome, FinerAnswer finer);

}  // namespace tactel::host
