// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "host/device/executor.h"
#include "host/figures/page.h"

namespace tactel::host {

/// Solves the paper's direct problem and adds it to the report: Table I, Figures 3 to 5, and the effect on Table I
/// of the parameters that the paper leaves open. Returns table1.json: [{"u_x" mm, "sigma_y" %, "tau_xy" %}].
nlohmann::ordered_json report_direct_problem(Executor& executor, Page& page);

}  // namespace tactel::host
