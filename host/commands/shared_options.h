// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/answers/solve.h"
#include "host/commands/command.h"

namespace tactel::host {

/// Options of every command that computes.
struct SharedOptions {
  SolveOptions solve;
  bool quiet = false;
};
/// `precision`: the default in the help text.
void add_shared_options(CLI::App& command, SharedOptions& options,
                        const char* precision = "fp64, or fp32 on a device without it");

/// Options of the commands that use networks.
struct NetworkOptions {
  std::string device, precision = "fp32";
  bool quiet = false;
};
void add_network_options(CLI::App& command, std::string& device, std::string& precision, bool& quiet);

void add_device_option(CLI::App& command, std::string& device);

/// Writes index.html into the folder of --output, and prints where it is.
void write_report(const std::string& folder, const std::string& page, bool quiet);

}  // namespace tactel::host
