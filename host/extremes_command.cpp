#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "host/command.h"
#include "host/extremes.h"

namespace tactel::host {
namespace {

int run_extremes(const std::string& device, const ExtremesOptions& options) {
  Executor executor{Device(device)};
  const bool terminal = isatty(STDERR_FILENO);
  const auto extremes = scene_extremes(executor, options, [&](std::size_t done, std::size_t total) {
    if (terminal) fmt::print(stderr, "\r{} of {} scenes", done, total);
    return true;
  });
  if (terminal) fmt::print(stderr, "\r{:30}\r", "");
  fmt::print("{}\n", extremes_table(extremes));
  const auto findings = extreme_findings(executor, options);
  fmt::print("{}", findings_table(findings));
  const auto solved = [](const Extreme& e) { return e.fp32.solved && e.fp64.solved && e.reference.solved; };
  return std::ranges::all_of(extremes, solved) && std::ranges::all_of(findings, &ExtremeFinding::good) ? done
                                                                                                       : not_converged;
}

}  // namespace

void add_extremes_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ExtremesOptions>();
  auto device = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("extremes", "what the solvers do at the ends of what a scene may say, as a table");
  command->add_flag("--quick", options->quick, "shorter paths and no mesh beyond 123 x 33: seconds instead of minutes");
  command->add_option("--device", *device, "OpenCL device: a part of its name or its index, see `tactel devices`")
      ->type_name("NAME|INDEX");
  command->callback([=, &action] { action = [=] { return run_extremes(*device, *options); }; });
}

}  // namespace tactel::host
