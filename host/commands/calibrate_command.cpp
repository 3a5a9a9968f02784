// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "host/commands/calibrate_plan_command.h"
#include "host/commands/calibrate_sensor_command.h"
#include "host/commands/shared_options.h"
#include "host/networks/onnx_file.h"
#include "host/support/durable_file.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"
#include "host/training/calibration.h"

namespace tactel::host {
namespace {

struct CalibrateBoundRequest {
  NetworkOptions shared;
  std::string network, set, output;
  double level = 0.95, least = 0;
  std::vector<std::string> left_out;  ///< network and set, in turn
  double left_out_level = 0.9;
};

int run_calibrate_bound(const CalibrateBoundRequest& request) {
  const std::string& output = request.output.empty() ? request.network : request.output;
  NamedNetwork network{request.network, read_onnx(request.network)};
  check_writable("--output", output);
  const ContactSet set = [&] {
    const StageLine stage("reading " + request.set, request.shared.quiet);
    return read_contact_set(request.set);
  }();
  if (!request.shared.quiet && request.set == network.model.learning_set)
    print_warning(request.set + ": the network learnt from this set; its bound holds only on rows of another seed");
  Executor executor{Device(request.shared.device)};
  const nn::Calibration report = calibrate_bound(executor, network, set, request.set, request.level, request.least);
  for (std::size_t k = 0; k + 1 < request.left_out.size(); k += 2) {
    const std::string& witness = request.left_out[k];
    const std::string& rows = request.left_out[k + 1];
    widen_bound(executor, network, {witness, read_onnx(witness)}, read_contact_set(rows), rows, request.left_out_level);
  }
  write_onnx(output, network.model);
  if (request.shared.quiet) return done;
  fmt::print(
      "{}: bound of {:g} %, calibrated on {} rows of {} (seed {}); {} of {} classes have a correction of "
      "their own\n",
      output, 100 * request.level, report.rows, request.set, set.seed, report.own_classes, report.classes);
  if (request.least > 0)
    fmt::print("every kind of indenter, group of touching elements and tenth of S has {:.1f} % or more of its rows\n",
               100 * report.least);
  if (report.least < request.least - 1e-3)
    print_warning(fmt::format("{:g} % of every kind were asked: the classes of the bound cannot serve all kinds alike",
                              100 * request.least));
  if (const std::string& sets = network.model.bound->left_out; !sets.empty())
    fmt::print("widened to hold at {:g} % on {}, which {} did not learn\n", 100 * request.left_out_level, sets,
               request.left_out.size() > 2 ? "other networks" : request.left_out.front());
  if (!report.known)
    print_warning(
        fmt::format("{} rows do not tell which frames are unlike the others ({} are needed): that limit stays "
                    "as it was",
                    report.rows, nn::fewest_scores(nn::Bound::known_share)));
  return done;
}

}  // namespace

void add_calibrate_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "calibrate", "plan presses, calibrate a sensor by them, or the bound of a network by other data");
  command->group("Learn");
  command->require_subcommand(1);
  add_calibrate_plan_command(*command, action);
  add_calibrate_sensor_command(*command, action);
  auto request = std::make_shared<CalibrateBoundRequest>();
  CLI::App* bound = command->add_subcommand(
      "bound", "renew the bound of a network by the rows of a set: conformal corrections and known frames");
  bound->add_option("network", request->network, "network with a bound, see tactel train --bound")
      ->type_name("FILE.onnx")
      ->required();
  bound->add_option("set", request->set, "set to calibrate by (HDF5), of another seed than the learning set")
      ->type_name("SET.h5")
      ->required();
  bound->add_option("--output", request->output, "network file to write (default: in place)")->type_name("FILE.onnx");
  bound->add_option("--level", request->level, "share of new frames whose S shall be below the bound, no unit")
      ->check(CLI::Range(0.5, 0.9999))
      ->capture_default_str();
  bound
      ->add_option(
          "--least", request->least,
          "share of the rows of every kind of indenter, group of touching elements and tenth of S that shall be "
          "below the bound and within the interval, no unit; 0: of all rows only")
      ->check(CLI::Range(0.0, 0.999))
      ->capture_default_str();
  bound
      ->add_option("--left-out", request->left_out,
                   "another network and a set of families that it did not learn: the bound becomes at least as wide as "
                   "this network needs there; repeatable")
      ->type_name("NET.onnx SET.h5")
      ->type_size(2)
      ->expected(1, 16);
  bound
      ->add_option("--left-out-level", request->left_out_level,
                   "share of the rows of such a set whose S shall be below the bound, no unit")
      ->check(CLI::Range(0.5, 0.9999))
      ->capture_default_str();
  bound
      ->add_option("--device", request->shared.device,
                   "OpenCL device: a part of its name or its index, see `tactel devices`")
      ->type_name("NAME|INDEX");
  bound->add_flag("--quiet", request->shared.quiet, "no progress, no warnings and no summary");
  bound->callback([request, &action] { action = [request] { return run_calibrate_bound(*request); }; });
}

}  // namespace tactel::host
