#pragma once
#include <CLI/CLI.hpp>
#include <functional>

#include "host/solve.h"

namespace tactel::host {

/// How the program ends; users' scripts rely on these.
enum ExitCode { done = 0, wrong_input = 2, device_failed = 3, not_converged = 4 };

/// What the chosen command does, and the exit code it ends with. Set by the command's callback, run after parsing.
using Action = std::function<int()>;

void add_solve_command(CLI::App& app, Action& action);
void add_generate_command(CLI::App& app, Action& action);
void add_reproduce_command(CLI::App& app, Action& action);
void add_tradeoff_command(CLI::App& app, Action& action);

/// Options of every command that computes.
struct SharedOptions {
  SolveOptions solve;
  bool quiet = false;
};
void add_shared_options(CLI::App& command, SharedOptions& options);

}  // namespace tactel::host
