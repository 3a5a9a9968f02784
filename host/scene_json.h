#pragma once
#include <nlohmann/json.hpp>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/solve.h"

namespace tactel::host {

/// A scene as its file would say it, with every default filled in (a measured profile: its file and its points).
nlohmann::ordered_json to_json(const fem::Scene& scene);

/// The whole answer, keys and units as docs/scenes.md lists them. Numbers read back to the same bits.
nlohmann::ordered_json to_json(const fem::Scene& scene, const SolveOutcome& outcome);

}  // namespace tactel::host
