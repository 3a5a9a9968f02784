// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/commands/shared_options.h"
#include "host/studies/extremes/extremes.h"
#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

struct ExtremesRequest {
  std::string device;
  bool quick = false, quiet = false;
};

int run_extremes(const ExtremesRequest& request) {
  Executor executor{Device(request.device)};
  const auto extremes = [&] {
    ProgressLine line("extreme scenes", "scenes", request.quiet);
    return scene_extremes(executor, request.quick, [&](std::size_t done, std::size_t total) {
      line.show(done, total);
      return true;
    });
  }();
  fmt::print("{}\n", extremes_table(extremes));
  const auto findings = [&] {
    const StageLine stage("drift, restarts and paths at the extremes", request.quiet);
    return extreme_findings(executor, request.quick);
  }();
  fmt::print("{}", findings_table(findings));
  const auto solved = [](const Extreme& e) { return e.fp32.solved && e.fp64.solved && e.reference.solved; };
  return std::ranges::all_of(extremes, solved) && std::ranges::all_of(findings, &ExtremeFinding::good) ? done
                                                                                                       : not_converged;
}

}  // namespace

void add_extremes_command(CLI::App& app, Action& action) {
  const auto [command, request] = add_command(
      app, action, "Verify", "extremes", "test the solvers at the limits of valid scenes, as a table", run_extremes);
  add_option(command, "--quick", request.quick,
             "shorter paths and no mesh beyond 123 x 33: seconds instead of minutes");
  add_device_option(command, request.device);
  add_option(command, "--quiet", request.quiet, "no progress on stderr");
}

}  // namespace tactel::host
