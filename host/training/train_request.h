// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "host/networks/training_plan.h"
#include "host/training/named_network.h"
#include "host/training/train_options.h"

namespace tactel::host {

/// Returns the history of --history "k" or "k:stride", empty for 1, and --history-change. Throws ConfigError.
nn::InputHistory parse_history(const std::string& text, std::optional<double> change);

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
