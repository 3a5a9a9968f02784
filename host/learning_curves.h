#pragma once
#include <span>

#include "host/network_sweep.h"
#include "host/plot.h"

namespace tactel::host {

/// Sum of squared errors and largest error over cycles, on logarithmic axes; two panels for each level of noise. A
/// curve a topology: its network's, or the median over seeds in a band from the 5 to the 95 % quantile. A network that
/// has stopped keeps the errors of its last cycle. stop_error: drawn as a line.
Figure learning_curves(std::span<const SweepNetwork> networks, double stop_error);

}  // namespace tactel::host
