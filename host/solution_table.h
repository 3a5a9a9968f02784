#pragma once
#include <string>

#include "fem/scene.h"
#include "host/solve.h"

namespace tactel::host {

/// The answer for people: what was solved, then a line per load step.
std::string solution_table(const fem::Scene& scene, const SolveOutcome& outcome);

}  // namespace tactel::host
