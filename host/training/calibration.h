// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/device/executor.h"
#include "host/training/named_network.h"

namespace tactel::host {

/// Calibrates the bound of a network anew by the rows of a set, in the classes of today (nn::renew_classes): in fp32,
/// as monitor and the libraries evaluate it. least: of the rows of every kind of indenter, group of touching elements
/// and tenth of S (nn::raise); 0: of none. `file`: of the set, for errors and the network's metadata. Throws
/// ConfigError, naming the network's file or the set's, for a network without a bound, frames of another width, and too
/// few rows.
nn::Calibration calibrate_bound(Executor& executor, NamedNetwork& network, const ContactSet& set,
                                const std::string& file, double level, double least = 0);

/// Widens the bound of `network` by rows of families that it may meet and has not learnt: `witness` did not learn them
/// either. Its bound on `set`, at `level`, in the classes of `network`, becomes the least of each class. Throws
/// ConfigError as calibrate_bound, and for a witness of other inputs.
void widen_bound(Executor& executor, NamedNetwork& network, NamedNetwork witness, const ContactSet& set,
                 const std::string& file, double level);

}  // namespace tactel::host
