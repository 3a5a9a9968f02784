// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/figures/page.h"
#include "host/figures/plot.h"
#include "host/studies/tradeoff/tradeoff.h"

namespace tactel::host {

nlohmann::ordered_json to_json(const Tradeoff& tradeoff);
nlohmann::ordered_json to_json(const std::vector<Promise>& promises);

/// Returns a figure of the error in S against speed, and the Pareto front.
Figure tradeoff_figure(const Tradeoff& tradeoff);
/// Returns a figure of the error in S as one quantity after the other is refined.
Figure sources_figure(const Tradeoff& tradeoff);

std::string tradeoff_page(const Tradeoff& tradeoff);

/// Returns the table for a terminal.
std::string tradeoff_table(const Tradeoff& tradeoff);
std::string promise_table(const std::vector<Promise>& promises);

/// Returns the text of host/contact/measured_ladder.cpp.
std::string planner_source(const Tradeoff& tradeoff, const std::string& command);

}  // namespace tactel::host
