#pragma once
#include <CLI/CLI.hpp>
#include <functional>

#include "host/solve.h"

namespace tactel::host {

/// How the program ends; users' scripts rely on these. Stopped by a signal: interrupt.h.
enum ExitCode { done = 0, wrong_input = 2, device_failed = 3, not_converged = 4 };

/// What the chosen command does, and the exit code it ends with. Set by the command's callback, run after parsing.
using Action = std::function<int()>;

void add_solve_command(CLI::App& app, Action& action);
void add_generate_command(CLI::App& app, Action& action);
void add_train_command(CLI::App& app, Action& action);
void add_recall_command(CLI::App& app, Action& action);
void add_reproduce_command(CLI::App& app, Action& action);
void add_tradeoff_command(CLI::App& app, Action& action);
void add_extremes_command(CLI::App& app, Action& action);
void add_monitor_command(CLI::App& app, Action& action);
void add_record_command(CLI::App& app, Action& action);
void add_tare_command(CLI::App& app, Action& action);

/// Options of every command that computes.
struct SharedOptions {
  SolveOptions solve;
  bool quiet = false;
};
void add_shared_options(CLI::App& command, SharedOptions& options);

/// Options of the commands that train and use networks.
struct NetworkOptions {
  std::string device, precision = "fp32";
  bool quiet = false;
};
void add_network_options(CLI::App& command, NetworkOptions& options);

/// Options of the commands that read a sensor.
void add_source_options(CLI::App& command, std::string& source, std::string& profile, std::string& calibration);

}  // namespace tactel::host
