// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "host/figures/page.h"
#include "host/studies/paper/inverse_baselines.h"
#include "host/studies/paper/inverse_problem.h"

namespace tactel::host {

/// Returns table2.json: for each network and noise the medians over seeds of max, mean and standard deviation,
/// learning and recalling, with the 5 and 95 % quantiles as "low" and "high".
nlohmann::ordered_json table_two_json(const InverseProblem& problem);

/// Adds to the report Table II as a distribution, with the estimators without a network; learning curves, and errors
/// by class and by nodes in contact. Adds the effect of noise.
void report_inverse_problem(Page& page, const InverseProblem& problem, const InverseChoice& choice,
                            const InverseBaselines& baselines);

}  // namespace tactel::host
