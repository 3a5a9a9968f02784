// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "host/training/train_request.h"
#include "host/training/training_job.h"

namespace tactel::host {

/// Returns a job that trains on a whole set and judges the networks on a recall set, where one is given. All
/// arguments must outlive the job. Throws ConfigError for a set that the plan cannot learn from.
std::unique_ptr<TrainingJob> set_training(const TrainRequest& request, const TrainingPlan& plan, const NamedSet& set,
                                          const std::optional<NamedSet>& recall_set);

}  // namespace tactel::host
