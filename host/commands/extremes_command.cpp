// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "host/commands/command.h"
#include "host/studies/extremes/extremes.h"
#include "host/studies/extremes/extremes_page.h"
#include "host/support/durable_file.h"
#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

struct ExtremesRequest {
  std::string device, html;
  ExtremesOptions options;
  bool quiet = false;
};

std::vector<Extreme> solve_extremes(const ExtremesRequest& request, Executor& executor) {
  ProgressLine line("extreme scenes", "scenes", request.quiet);
  return scene_extremes(executor, request.options, [&](std::size_t done, std::size_t total) {
    line.show(done, total);
    return true;
  });
}

std::vector<ExtremeFinding> find_extremes(const ExtremesRequest& request, Executor& executor) {
  const StageLine stage("drift, restarts and paths at the extremes", request.quiet);
  return extreme_findings(executor, request.options);
}

int run_extremes(const ExtremesRequest& request) {
  if (!request.html.empty()) check_writable("--html", request.html);
  Executor executor{Device(request.device)};
  const auto extremes = solve_extremes(request, executor);
  fmt::print("{}\n", extremes_table(extremes));
  const auto findings = find_extremes(request, executor);
  fmt::print("{}", findings_table(findings));
  if (!request.html.empty())
    write_file("--html", request.html, extremes_page(extremes, findings, executor.device().info().name).html());
  const auto solved = [](const Extreme& e) { return e.fp32.solved && e.fp64.solved && e.reference.solved; };
  return std::ranges::all_of(extremes, solved) && std::ranges::all_of(findings, &ExtremeFinding::good) ? done
                                                                                                       : not_converged;
}

}  // namespace

void add_extremes_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<ExtremesRequest>();
  CLI::App* command = app.add_subcommand("extremes", "test the solvers at the limits of valid scenes, as a table");
  command->group("Verify");
  command->add_flag("--quick", request->options.quick,
                    "shorter paths and no mesh beyond 123 x 33: seconds instead of minutes");
  command->add_option("--html", request->html, "write both tables as a page")->type_name("FILE.html");
  command
      ->add_option("--device", request->device, "OpenCL device: a part of its name or its index, see `tactel devices`")
      ->type_name("NAME|INDEX");
  command->add_flag("--quiet", request->quiet, "no progress on stderr");
  command->callback([=, &action] { action = [=] { return run_extremes(*request); }; });
}

}  // namespace tactel::host
