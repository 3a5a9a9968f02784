// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <future>
#include <optional>
#include <string>

#include "host/answers/planner.h"
#include "host/answers/rung_error.h"

namespace tactel::host {

/// The answer of a scene's finer model. Begun before the scene is solved, it takes the time of another core.
using FinerAnswer = std::future<fem::ContactSolution>;

/// Begins to solve a scene on a mesh with half the element size, in a thread of its own. Returns a future without a
/// state where mesh_error would not solve it, or where the load path depends on the scene's own answer.
FinerAnswer begin_finer(const fem::Scene& scene);

/// Returns the error to expect of an answer: exact contact solves the scene again with half the element size, or the
/// patch's twin with twice the elements, or the exact solver with half of more than 24. None where that would take
/// seconds (more than 81 columns, 33 rows or 100 load steps), and where it fails.
/// `finer`: of begin_finer; without a state it is made here.
std::optional<ExpectedError> mesh_error(const fem::Scene& scene, const fem::ContactSolution& answer,
                                        FinerAnswer finer = {});

/// Returns why mesh_error has no estimate of an answer: "it has more than 81 columns ..." or "24 elements ...".
std::string why_no_estimate(const fem::Scene& scene, const fem::ContactSolution& answer);

/// Returns what the planner knows of its answer's error; none where a mesh missed a contact or no rung was compared.
std::optional<ExpectedError> mesh_error(const RungChoice& plan);

}  // namespace tactel::host
