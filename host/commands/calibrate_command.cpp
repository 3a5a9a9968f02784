// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "host/commands/add_option.h"
#include "host/commands/network_parts.h"
#include "host/commands/shared_options.h"
#include "host/networks/onnx_file.h"
#include "host/support/durable_file.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"
#include "host/training/named_network.h"

namespace tactel::host {
namespace {

struct CalibrateBoundRequest {
  NetworkOptions shared;
  std::string network, set, output;
  double level = 0.95;
};

int run_calibrate_bound(const CalibrateBoundRequest& request) {
  const std::string& output = request.output.empty() ? request.network : request.output;
  std::vector<NamedNetwork> networks = {{request.network, read_onnx(request.network)}};
  check_writable("--output", output);
  calibrate_bounds(networks, request.set, request.level, request.shared, output);
  return done;
}

}  // namespace

void calibrate_bounds(std::span<NamedNetwork> networks, const std::string& file, double level,
                      const NetworkOptions& options, const std::string& output) {
  const ContactSet set = [&] {
    const StageLine stage("reading " + file, options.quiet);
    return read_contact_set(file, unread(false));
  }();
  Executor executor{Device(options.device)};
  for (NamedNetwork& network : networks) {
    if (!options.quiet && file == network.model.learning_set)
      print_warning(file + ": the network learnt from this set; its bound holds only on rows of another seed");
    const nn::Calibration report = calibrate_bound(executor, network, set, file, level);
    const std::string& written = output.empty() ? network.file : output;
    write_onnx(written, network.model);
    if (options.quiet) continue;
    fmt::print(
        "{}: bound of {:g} %, calibrated on {} rows of {} (seed {}); {} of {} classes have a correction of "
        "their own\n",
        written, 100 * level, report.rows, file, set.seed, report.own_classes, report.classes);
    if (!report.known)
      print_warning(
          fmt::format("{} rows do not tell which frames are unlike the others ({} are needed): that limit stays "
                      "as it was",
                      report.rows, nn::fewest_scores(nn::Bound::known_share)));
  }
}

void add_calibrate_command(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("calibrate", "renew the conformal bound of a network; of sensors: python -m tactel.calibrate");
  command->require_subcommand(1);
  const auto [bound, request] =
      add_command(*command, action, command->get_group().c_str(), "bound",
                  "renew the conformal bound of a network by the rows of a set", run_calibrate_bound);
  add_option(bound, "network", request.network,
             "network with a bound, see tactel train --bound (whose --bound-set does the same)", {.type = "FILE.onnx"})
      ->required();
  add_option(bound, "set", request.set, "set to calibrate by (HDF5), of another seed than the learning set",
             {.type = "SET.h5"})
      ->required();
  add_option(bound, "--output", request.output, "network file to write (default: in place)", {.type = "FILE.onnx"});
  add_option(bound, "--level", request.level, "share of new frames whose S shall be below the bound, no unit",
             {.least = 0.5, .most = 0.9999});
  add_device_option(bound, request.shared.device);
  add_option(bound, "--quiet", request.shared.quiet, "no progress, no warnings and no summary");
  command->group("Learn");  // here, or its own commands would be in this group
}

}  // namespace tactel::host
