// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "host/figures/plot.h"
#include "host/networks/network_training.h"

namespace tactel::host {

/// Returns a figure of the sum of squared errors and the largest error over cycles, on logarithmic axes; two
/// panels for each level of noise. Each topology has a curve: that of its network, or the median over seeds in a
/// band from the 5 to the 95 % quantile. A stopped network keeps the errors of its last cycle. stop_error is
/// drawn as a line.
Figure learning_curves(std::span<const TrainedNetwork> networks, double stop_error);

/// Returns a figure of the errors of networks that learn from a stream, over rows seen (`curve.cycle`), on
/// logarithmic axes. It shows the root mean square error of each block before the network learned it (`sse`: its
/// mean square). Where the networks were validated, it also shows the mean error on the validation set (`largest`).
/// Networks that differ only in their seed share a colour.
Figure stream_curves(std::span<const TrainedNetwork> networks, bool validated);

}  // namespace tactel::host
