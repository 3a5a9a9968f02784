// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "host/training/train_request.h"
#include "host/training/training_job.h"

namespace tactel::host {

/// Mini-batch training on frames in blocks: new contacts of a sweep file (--stream), or a set file larger than
/// memory (--block). The learning rate falls linearly to a hundredth of its start. A network that diverges is
/// trained no further and has no file. `request` and `plan` must outlive the job. Throws ConfigError for frames
/// that the plan cannot learn from.
std::unique_ptr<TrainingJob> stream_training(const TrainRequest& request, const TrainingPlan& plan);

}  // namespace tactel::host
