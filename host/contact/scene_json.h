// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/contact/solve.h"

namespace tactel::host {

/// Returns a scene as in its file, with every default filled in (of a measured profile: its file and its points).
nlohmann::ordered_json to_json(const fem::Scene& scene);

/// Returns the whole answer, with the keys and units of docs/answers.md. Numbers read back to the same bits.
nlohmann::ordered_json to_json(const fem::Scene& scene, const SolveOutcome& outcome);

}  // namespace tactel::host
