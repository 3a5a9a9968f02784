#include <fmt/format.h>

#include <chrono>

#include "host/command.h"
#include "host/errors.h"
#include "host/sweep_file.h"

namespace tactel::host {
namespace {

struct GenerateRequest {
  SharedOptions shared;
  std::string sweep, output;
  bool force = false;
};

void refuse_existing(const GenerateRequest& request) {
  if (!request.force && std::filesystem::exists(request.output))
    throw ConfigError("command line", "--output", request.output,
                      "a file that is not there yet, or --force to write over it");
}

int run_generate(const GenerateRequest& request) {
  const Sweep sweep = read_sweep(request.sweep);
  refuse_existing(request);
  const SolveOptions& solve = request.shared.solve;
  if (solve.solver != "batched") throw ConfigError("command line", "--solver", solve.solver, "batched for sets");
  Executor executor{Device(solve.device)};
  const bool fp32 = solve.precision == "fp32" || (solve.precision.empty() && !executor.device().info().fp64);
  const auto start = std::chrono::steady_clock::now();
  ContactSet set = simulate_family(executor, sweep.family, fp32 ? Precision::fp32 : Precision::fp64,
                                   0.01 * solve.tolerance.value_or(0));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  set.sweep = sweep.text;
  set.rung = fp32 ? "fp32" : "fp64";
  write_contact_set(request.output, set);
  if (!request.shared.quiet)
    fmt::print("{}: {} load steps of {} contacts in {:.2f} s; {} by the exact fallback, {} unsolved\n", request.output,
               set.rows(), sweep.family.scenes.size(), seconds, set.fell_back, set.unsolved);
  return set.unsolved ? not_converged : done;
}

}  // namespace

void add_generate_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<GenerateRequest>();
  CLI::App* command = app.add_subcommand("generate", "a set of many contacts, as HDF5");
  command->add_option("sweep", request->sweep, "sweep file (TOML; mm, MPa)")->type_name("SWEEP.toml")->required();
  command->add_option("--output", request->output, "the set to write")->type_name("SET.h5")->required();
  command->add_flag("--force", request->force, "write over an existing file");
  add_shared_options(*command, request->shared);
  command->callback([request, &action] { action = [request] { return run_generate(*request); }; });
}

}  // namespace tactel::host
