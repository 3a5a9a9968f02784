// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/device/executor.h"
#include "host/training/named_network.h"

namespace tactel::host {

/// Calibrates the bound of a network anew by the rows of a set, in the classes of today (nn::renew_classes): in fp32,
/// as monitor and the libraries evaluate it. `file`: of the set, for errors and the network's metadata. Throws
/// ConfigError, naming the network's file or the set's, for a network without a bound, frames of another width, and too
/// few rows.
nn::Calibration calibrate_bound(Executor& executor, NamedNetwork& network, const ContactSet& set,
                                const std::string& file, double level);

}  // namespace tactel::host
