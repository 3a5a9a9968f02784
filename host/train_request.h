#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/command.h"
#include "host/named_network.h"
#include "host/network_sweep.h"

namespace tactel::host {

/// The command line of `tactel train`.
struct TrainRequest {
  NetworkOptions shared;
  std::string set, stream, recall_set, output;
  std::optional<std::int64_t> block;  ///< rows of a set file to read at a time
  std::uint64_t rows = 10'000'000;    ///< of a stream to learn from
  std::vector<std::string> networks;
  std::vector<double> noises;
  std::uint64_t seeds = 1, first_seed = 1;
  std::string scaling = "set", schedule = "online", order = "permuted";
  std::optional<double> rate, momentum;
  std::optional<int> cycles, batch;
  std::optional<std::string> optimizer;
  double stop_error = 0.01, checkpoint_seconds = 10;
  bool resume = false, force = false;
};

/// A set's file and the rows of it that count.
struct NamedSet {
  std::string file;
  ContactSet contacts;
  AnsweredRows rows;
};
/// Throws ConfigError as read_contact_set and answered_rows.
NamedSet read_set(const std::string& file);
/// The same, and throws ConfigError for a set that nothing can be learnt from.
NamedSet read_learning_set(const TrainRequest& request);

/// What to train. Throws ConfigError, naming the option.
SweepPlan plan_of(const TrainRequest& request);
/// Throws ConfigError when a network has another number of inputs than the set.
void check_width(const SweepPlan& plan, const NamedSet& set);

}  // namespace tactel::host
