// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/answers/solve.h"
#include "host/figures/page.h"
#include "host/scenes/scene_json.h"

namespace tactel::host {

/// Returns the whole answer, with the keys and units of docs/answers.md. Numbers read back to the same bits.
nlohmann::ordered_json to_json(const SolveOutcome& outcome);
nlohmann::ordered_json to_json(const PadOutcome& outcome);

/// Returns the page of a solved contact: what became of it, the contact over its load steps with the step `shown`
/// first, and a table of the steps.
Page answer_page(const SolveOutcome& outcome, std::size_t shown);
Page answer_page(const PadOutcome& outcome, std::size_t shown);

/// Returns the answer as a table: scene, model and solver, then a line per load step, then what to expect of it.
std::string answer_table(const SolveOutcome& outcome);
std::string answer_table(const PadOutcome& outcome);

/// Returns a number with so many digits behind the point; a zero has no sign.
std::string fixed(double value, int digits);
/// Returns a number with four or five digits, in seven letters where its size is between 0.001 and 1000.
std::string short_number(double value);
/// Returns a share as two digits: "2.7 %".
std::string percent(double share);
/// Returns Q beside P: what rounding and tolerance leave of 0, below a millionth of P, is 0.
double without_rounding(double Q, double P);

}  // namespace tactel::host
