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

/// Whether a file is a recording of tactel record.
bool is_recording(const std::string& file);

/// Evaluates networks on the frames of a recording, in batches on a device, and prints what they say, or writes it.
/// json: a file, "-" for standard output, or empty; rows: a CSV file, or empty. Returns the exit code.
int recall_recording(std::span<const NamedNetwork> networks, const std::string& file, const NetworkOptions& shared,
                     const std::string& json, const std::string& rows);

}  // namespace tactel::host
