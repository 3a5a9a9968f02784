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
NamedSet read_set(const std::string& file, nn::Target target = nn::Target::slip_index, bool markers = false);
/// The same for the learning set, with history and |S| where they are asked for. Throws ConfigError also for a set that
/// cannot train a network.
NamedSet read_learning_set(const TrainRequest& request);

/// Returns the plan of a request. Throws ConfigError, naming the option, for invalid values and for options that
/// the requested kind of training does not use.
TrainingPlan plan_of(const TrainRequest& request);
/// Throws ConfigError where a network's number of inputs is not that of the plan's frames, of so many `inputs` each.
void check_width(const TrainingPlan& plan, int inputs, const std::string& file);
/// The same of a set; also where it lacks the rows that the plan's history needs.
void check_width(const TrainingPlan& plan, const NamedSet& set);

}  // namespace tactel::host
