// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/commands/command.h"
#include "host/scenes/sweep_file.h"
#include "host/studies/floor/floor.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/training/named_network.h"

namespace tactel::host {
namespace {

struct FloorRequest {
  std::string sweep, json, device;
  std::vector<std::string> networks;
  FloorOptions options;
  bool quiet = false;
};

int run_floor(const FloorRequest& request) {
  const Sweep sweep = read_sweep(request.sweep);
  if (!sweep.source.endless())
    throw ConfigError(request.sweep, "sweep.set", "a listed set",
                      "left out: a floor draws its contacts (sweep.contacts)");
  if (!request.json.empty() && request.json != "-") check_writable("--json", request.json);
  std::vector<nn::Model> models;
  std::vector<std::string> files;
  for (const std::string& path : request.networks)
    for (NamedNetwork& network : read_networks(path)) {
      models.push_back(std::move(network.model));
      files.push_back(network.file);
    }
  Executor executor{Device(request.device)};
  const Interrupt interrupt;
  ProgressLine line("floor", "readings", request.quiet);
  FloorOptions options = request.options;
  options.progress = [&](std::size_t done, std::size_t all) {
    line.show(done, all);
    return !interrupt.requested();
  };
  const auto floor = measure_floor(executor, sweep.source, models, options);
  line.clear();
  if (!floor) return interrupted;
  nlohmann::ordered_json json = {{"tactel", TACTEL_VERSION}, {"sweep", request.sweep}};
  json.update(to_json(*floor, options, files));
  if (request.json == "-") {
    fmt::print("{}", json_text(json));
    return done;
  }
  if (!request.json.empty()) write_file("--json", request.json, json_text(json));
  fmt::print("{}", floor_table(*floor, options, files));
  return done;
}

}  // namespace

void add_floor_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<FloorRequest>();
  FloorOptions& options = request->options;
  CLI::App* command = app.add_subcommand(
      "floor", "how well S can be read at all from the frames of a sweep: numbers below and above the smallest error");
  command->group("Verify");
  command->add_option("sweep", request->sweep, "sweep file (TOML)")->type_name("SWEEP.toml")->required();
  command
      ->add_option("--noise", options.noise,
                   "standard deviation of a reading's noise, over the largest |stress| of the newest frame")
      ->check(CLI::Range(1e-6, 10.0))
      ->capture_default_str();
  command
      ->add_option("--gain", options.gain,
                   "standard deviation of the transducers' gains about 1; they do not change along a contact")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--history", options.history, "frames of a reading: the newest and those before it")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_option("--network", request->networks, "also judge these networks on the readings (repeatable)")
      ->type_name("DIR|FILE.onnx");
  command->add_option("--bank", options.bank, "rows of the bank; more rows narrow the gap")
      ->check(CLI::Range(100, 100'000'000))
      ->capture_default_str();
  command->add_option("--readings", options.readings, "readings that are judged")
      ->check(CLI::Range(10, 10'000'000))
      ->capture_default_str();
  command->add_option("--seed", options.seed, "of noise and gains")->capture_default_str();
  command->add_option("--json", request->json, "write all numbers as JSON; - for standard output, instead of the table")
      ->type_name("FILE");
  command->add_option("--device", request->device, "OpenCL device: a part of its name or its index")
      ->type_name("NAME|INDEX");
  command->add_flag("--quiet", request->quiet, "print only errors and the result");
  command->callback([request, &action] { action = [request] { return run_floor(*request); }; });
}

}  // namespace tactel::host
