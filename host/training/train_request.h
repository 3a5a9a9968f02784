// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/networks/network_options.h"
#include "host/networks/training_plan.h"
#include "host/training/named_network.h"

namespace tactel::host {

/// The command line of `tactel train`.
struct TrainRequest {
  NetworkOptions shared;
  std::string set, stream, recall_set, validation_set, output;
  std::string rung{};                 ///< of the contacts of `stream`; empty: as its file says
  std::optional<std::int64_t> block;  ///< rows of a set file to read at a time
  std::optional<std::uint64_t> rows;  ///< of a stream to learn from; default_rows if not given
  std::vector<std::string> networks;
  std::vector<double> noises;
  std::uint64_t seeds = 1, first_seed = 1;
  std::string scaling = "set", order = "permuted";
  std::optional<std::string> history;  ///< "k" or "k:stride"
  std::optional<double> history_change;
  bool magnitude = false, friction = false;
  std::string features = "frame";
  std::string target = "slip_index";
  std::optional<double> alarm_at;
  std::optional<std::string> schedule;  ///< "online", "batch" or "cosine"; default: batch for a stream, else online
  std::optional<double> rate, momentum, warm_up, average;
  std::optional<int> cycles, batch, patience;
  std::optional<std::string> optimizer, activation, loss;
  std::optional<double> stop_error;
  bool bound = false;           ///< give every network the heads of a bound
  std::string bound_set;        ///< by which it is calibrated; empty: it is not
  std::optional<double> level;  ///< of that bound; 0.95 if not given
  double checkpoint_seconds = 10;
  bool resume = false, force = false;

  /// Frames block by block: simulated contacts, or a set file larger than memory.
  bool streams() const { return !stream.empty() || block.has_value(); }
  /// Images of a line's frame have S of both signs.
  bool learns_magnitude() const { return magnitude || features == "line"; }
  bool cosine() const { return schedule == "cosine"; }
  bool batches() const { return streams() || cosine() || schedule == "batch"; }
};
inline constexpr std::uint64_t default_rows = 10'000'000;

/// Returns the history of --history "k" or "k:stride" and --history-change. Throws ConfigError.
nn::InputHistory parse_history(const std::optional<std::string>& text, std::optional<double> change);

/// A set file and its usable rows.
struct NamedSet {
  std::string file;
  ContactSet contacts;
  AnsweredRows rows;
};
/// Throws ConfigError as read_contact_set and answered_rows.
NamedSet read_set(const std::string& file, nn::Target target = nn::Target::slip_index);
/// The same for the learning set, with history and |S| where they are asked for. Throws ConfigError also for a set that
/// cannot train a network.
NamedSet read_learning_set(const TrainRequest& request);

/// Returns the plan of a request. Throws ConfigError, naming the option, for invalid values and for options that
/// the requested kind of training does not use.
TrainingPlan plan_of(const TrainRequest& request);
/// Returns the name of a plan's topology as the user gives it: without the inputs of the rest and what is told.
std::string named(const nn::Topology& topology, const nn::InputHistory& history);
/// Throws ConfigError where a network's number of inputs differs from the set's, or the set lacks the rows that the
/// plan's history needs.
void check_width(const TrainingPlan& plan, const NamedSet& set);

}  // namespace tactel::host
