// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/answers/solve.h"
#include "host/figures/page.h"

namespace tactel::host {

/// Returns the page of a solved contact: what became of it, the contact over its load steps with the step `shown`
/// first, and a table of the steps.
Page answer_page(const SolveOutcome& outcome, std::size_t shown);
Page answer_page(const PadOutcome& outcome, std::size_t shown);

}  // namespace tactel::host
