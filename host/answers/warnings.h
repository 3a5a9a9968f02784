// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "host/answers/solve.h"

namespace tactel::host {

/// Returns the warnings about an answer, one line each; usually none. They concern units, depth, slip, a drag that
/// never slid, friction that holds the indenter above its first touch, other solutions, forces that fp32 does not
/// resolve, a rung cut to the largest mesh, and an error that is not estimated; on a pad also edges, steps that touch
/// nothing or few cells, a contact that the tactels hardly see, and errors that are large or were not measured.
std::vector<std::string> warnings(const SolveOutcome& outcome);
std::vector<std::string> warnings(const PadOutcome& outcome);

/// Returns true where a drag until sliding ended without sliding.
bool never_slid(const fem::Scene& scene, const fem::ContactSolution& solution);
inline bool never_slid(const fem::PadScene&, const fem::PadSolution&) { return false; }

/// Returns "load step 2" or "load steps 1 to 3, 5" of increasing numbers, at least one, that count from 1.
std::string steps_text(const std::vector<std::size_t>& numbers);

}  // namespace tactel::host
