#pragma once
#include "host/train_request.h"

namespace tactel::host {

/// Mini-batch training on frames that come block by block: fresh contacts of a sweep file (--stream), or a set file
/// larger than memory (--block). Writes the request's directory as run_training does. The learning rate falls linearly
/// to a hundredth of its start. Returns the program's exit code.
int run_stream_training(const TrainRequest& request, const SweepPlan& plan);

}  // namespace tactel::host
