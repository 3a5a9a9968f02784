// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "host/figures/plot.h"
#include "host/networks/training_plan.h"

namespace tactel::host {

/// What the curves of a training show.
struct CurveKind {
  bool stream = false;     ///< over rows seen, else over cycles
  bool judged = false;     ///< of a stream: with the mean error on a recall set
  bool validated = false;  ///< with the mean error on a validation set
  double stop_error = 0;   ///< of a set: a line where the training stops
};

/// Returns a figure of errors on logarithmic axes; two panels for each level of noise. Of a set: the sum of squared
/// errors and the largest error of a cycle. Of a stream: the root mean square error of a block before the networks
/// learned it, and the mean error on the recall set. That on a validation set is dashed, in a panel with the recall
/// set's or in a third one. Each topology has a curve: that of its network, or the median over
/// seeds in a band from the 5 to the 95 % quantile. A stopped network keeps the errors of its last cycle.
Figure learning_curves(std::span<const TrainedNetwork> networks, const CurveKind& kind);

}  // namespace tactel::host
