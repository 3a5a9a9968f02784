#pragma once
#include <string>

#include "fem/scene.h"
#include "host/contact/solve.h"

namespace tactel::host {

/// Returns the answer as a table: scene, model and solver, then a line per load step.
std::string solution_table(const fem::Scene& scene, const SolveOutcome& outcome);

}  // namespace tactel::host
