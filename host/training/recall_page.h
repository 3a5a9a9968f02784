// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

#include "host/figures/page.h"
#include "host/training/answered_rows.h"
#include "host/training/decision.h"
#include "host/training/named_network.h"

namespace tactel::host {

/// Returns the page of networks judged by a set: their errors beside those on their learning sets; of the best six,
/// predicted over true S, the distribution of errors, and errors by indenter and by S. Of the best network with a
/// bound, its coverage and width by class. `results` have their rows. decisions: [networks] curves of alarms, or empty.
Page recall_page(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                 const AnsweredRows& rows, const std::vector<std::string>& indenter_names, const std::string& set,
                 std::span<const std::vector<DecisionCurve>> decisions = {});

}  // namespace tactel::host
