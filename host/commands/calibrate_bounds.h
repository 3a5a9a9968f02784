// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>

#include "host/commands/shared_options.h"
#include "host/training/named_network.h"

namespace tactel::host {

/// Calibrates the conformal bound of networks by a set and writes them, to `output` or in place; says what was done.
void calibrate_bounds(std::span<NamedNetwork> networks, const std::string& file, double level,
                      const NetworkOptions& options, const std::string& output = "");

}  // namespace tactel::host
