// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "host/support/ranks.h"
#include "host/training/train_request.h"
#include "host/training/training_job.h"

namespace tactel::host {

/// `tactel train` under mpirun. Every process trains the seeds with index mod processes = rank, in a directory of
/// its own (DIR/rank-K) with its own checkpoint. When all are complete, the first process writes networks and
/// report to DIR. With --resume and the same number of processes, each continues its own training. Every process
/// creates and runs the job. The outcome is that of all processes; only the first one has a summary. `ranks`,
/// `set` and `recall_set` must outlive the job. Throws ConfigError for an unusable directory.
std::unique_ptr<TrainingJob> rank_training(const Ranks& ranks, const TrainRequest& request, const TrainingPlan& plan,
                                           const NamedSet& set, const std::optional<NamedSet>& recall_set);

}  // namespace tactel::host
