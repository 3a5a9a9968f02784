#pragma once
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/named_network.h"

namespace tactel::host {

/// Errors |S of the network - S of the set| as text for people. Up to 24 networks have a line each; of more, those that
/// differ in their seed alone share one, with the median and the 5 and 95 % quantiles over seeds.
std::string error_table(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results);

/// Mean errors, medians over seeds, a line for each kind of indenter and each number of nodes in contact.
std::string error_table_by_kind(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                                const std::vector<std::string>& indenter_names);

/// {"max", "mean", "std", "rows"}; the first three null where rows is 0.
nlohmann::ordered_json to_json(const nn::ErrorSummary& errors);

/// Where a network comes from: file, number in the paper or null, topology, scaling, seed, noise, cycles, learning set
/// and errors on that.
nlohmann::ordered_json to_json(const NamedNetwork& network);

/// What it made of a set: errors in all, by kind of indenter and nodes in contact, and frames by status.
nlohmann::ordered_json to_json(const NetworkResult& result, const std::vector<std::string>& indenter_names);

}  // namespace tactel::host
