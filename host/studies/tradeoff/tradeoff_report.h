// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/figures/plot.h"
#include "host/studies/tradeoff/tradeoff.h"

namespace tactel::host {

nlohmann::ordered_json to_json(const Tradeoff& tradeoff);

/// Returns a figure of the error in S against speed, and the Pareto front.
Figure tradeoff_figure(const Tradeoff& tradeoff);

std::string tradeoff_page(const Tradeoff& tradeoff);

/// Returns the table for a terminal.
std::string tradeoff_table(const Tradeoff& tradeoff);

}  // namespace tactel::host
