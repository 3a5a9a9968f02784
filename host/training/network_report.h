// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/figures/page.h"
#include "host/training/answered_rows.h"
#include "host/training/decision.h"
#include "host/training/named_network.h"

namespace tactel::host {

/// Returns "errors |S - S of the set|", or of another target.
std::string errors_of(nn::Target target);

/// Returns the errors |S of the network - S of the set| as a table. Up to 24 networks have a line each. Of more,
/// those that differ in their seed alone share a line, with the median and the 5 and 95 % quantiles over seeds.
std::string error_table(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results);

/// Returns a table of mean errors, medians over seeds: a line for each kind of indenter and each number of
/// touching nodes.
std::string error_table_by_kind(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                                const std::vector<std::string>& indenter_names);

/// Returns {"max", "mean", "std", "rows"}; the first three are null where rows is 0.
nlohmann::ordered_json to_json(const nn::ErrorSummary& errors);

/// Returns the origin of a network: file, number in the paper or null, topology, scaling, seed, noise, cycles,
/// learning set and the errors on it.
nlohmann::ordered_json to_json(const NamedNetwork& network);

/// Returns the errors of a network on a set: in all, by kind of indenter and touching nodes; and the frames by
/// status.
nlohmann::ordered_json to_json(const NetworkResult& result, const std::vector<std::string>& indenter_names);

/// Returns the page of networks judged by a set: their errors beside those on their learning sets; of the best six,
/// predicted over true S, the distribution of errors, and errors by indenter and by S. Of the best network with a
/// bound, its coverage and width by class. `results` have their rows. decisions: [networks] curves of alarms, or empty.
Page recall_page(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                 const AnsweredRows& rows, const std::vector<std::string>& indenter_names, const std::string& set,
                 std::span<const std::vector<DecisionCurve>> decisions = {});

}  // namespace tactel::host
