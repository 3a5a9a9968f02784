#pragma once
#include "host/train_request.h"

namespace tactel::host {

/// Trains what the request asks for, from its directory's checkpoint if need be, and writes the directory. Returns the
/// program's exit code: done, not_converged where a network diverged, interrupted after Ctrl-C.
int run_training(const TrainRequest& request, const SweepPlan& plan, const NamedSet& set,
                 const std::optional<NamedSet>& recall_set);

}  // namespace tactel::host
