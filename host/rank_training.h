#pragma once
#include "host/ranks.h"
#include "host/train_request.h"

namespace tactel::host {

/// `tactel train` under mpirun: every process trains the seeds whose place leaves its rank over the number of
/// processes, in a directory of its own (DIR/rank-K) with its own checkpoint; when all are done the first process puts
/// networks and report together in DIR. With --resume and as many processes a training goes on where each of them was.
/// Returns the program's exit code.
int run_rank_training(const Ranks& ranks, TrainRequest request, SweepPlan plan, const NamedSet& set,
                      const std::optional<NamedSet>& recall_set);

}  // namespace tactel::host
