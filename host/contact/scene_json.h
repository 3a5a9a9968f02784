// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/contact/solve.h"
#include "host/scenes/scene_json.h"

namespace tactel::host {

/// Returns the whole answer, with the keys and units of docs/answers.md. Numbers read back to the same bits.
nlohmann::ordered_json to_json(const fem::Scene& scene, const SolveOutcome& outcome);

}  // namespace tactel::host
