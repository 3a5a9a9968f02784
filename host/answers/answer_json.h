// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "host/answers/solve.h"
#include "host/scenes/scene_json.h"

namespace tactel::host {

/// Returns the whole answer, with the keys and units of docs/answers.md. Numbers read back to the same bits.
nlohmann::ordered_json to_json(const SolveOutcome& outcome);
nlohmann::ordered_json to_json(const PadOutcome& outcome);

}  // namespace tactel::host
