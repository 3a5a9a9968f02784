// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <functional>

#include "host/support/exit_code.h"

namespace tactel::host {

/// Runs the chosen command and returns its exit code. The callback of the command sets it; it runs after parsing.
using Action = std::function<int()>;

void add_devices_command(CLI::App& app, Action& action);
void add_solve_command(CLI::App& app, Action& action);
void add_generate_command(CLI::App& app, Action& action);
void add_check_command(CLI::App& app, Action& action);
void add_train_command(CLI::App& app, Action& action);
void add_recall_command(CLI::App& app, Action& action);
void add_calibrate_command(CLI::App& app, Action& action);
void add_reproduce_command(CLI::App& app, Action& action);
void add_tradeoff_command(CLI::App& app, Action& action);
void add_extremes_command(CLI::App& app, Action& action);
void add_monitor_command(CLI::App& app, Action& action);
void add_record_command(CLI::App& app, Action& action);
void add_tare_command(CLI::App& app, Action& action);
void add_demo_command(CLI::App& app, Action& action);

}  // namespace tactel::host
