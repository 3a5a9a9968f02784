#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "host/plot.h"
#include "host/report_page.h"
#include "host/tradeoff.h"

namespace tactel::host {

nlohmann::ordered_json to_json(const Tradeoff& tradeoff);
nlohmann::ordered_json to_json(const std::vector<Promise>& promises);

/// Error in S against speed, and the front.
Figure tradeoff_figure(const Tradeoff& tradeoff);
/// Error in S as one thing after the other is made finer.
Figure sources_figure(const Tradeoff& tradeoff);

std::string tradeoff_page(const Tradeoff& tradeoff);

/// For a terminal.
std::string tradeoff_table(const Tradeoff& tradeoff);
std::string promise_table(const std::vector<Promise>& promises);

/// host/measured_ladder.cpp.
std::string planner_source(const Tradeoff& tradeoff, const std::string& command);

}  // namespace tactel::host
