// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/commands/shared_options.h"
#include "host/studies/tradeoff/tradeoff.h"
#include "host/support/durable_file.h"
#include "host/support/interrupt.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

constexpr std::size_t pad_scenes = 24;  ///< by default; the reference takes ten seconds for each

struct TradeoffRequest {
  std::string output = "tradeoff", device;
  TradeoffOptions options;
  std::optional<std::size_t> scenes{};
  bool pads = false, quiet = false;
};

int run_tradeoff(const TradeoffRequest& request) {
  const std::filesystem::path directory = request.output;
  make_folder("--output", directory);
  check_writable("--output", directory / "tradeoff.json");
  Executor executor{Device(request.device)};
  ProgressLine line("tradeoff", request.pads ? "scenes" : "models", request.quiet);
  const Interrupt interrupt;
  TradeoffOptions options = request.options;
  options.scenes = request.scenes.value_or(request.pads ? pad_scenes : options.scenes);
  options.progress = [&](std::size_t done, std::size_t total) {
    line.show(done, total);
    return !interrupt.requested();
  };
  const Tradeoff tradeoff = (request.pads ? measure_pad_tradeoff : measure_tradeoff)(executor, options);
  line.clear();
  write_file("--output", directory / "tradeoff.json", json_text(to_json(tradeoff)));
  write_figure("--output", directory / "tradeoff.svg", tradeoff_figure(tradeoff));
  fmt::print("{}", tradeoff_table(tradeoff));
  write_report(request.output, tradeoff_page(tradeoff), request.quiet);
  return done;
}

}  // namespace

void add_tradeoff_command(CLI::App& app, Action& action) {
  const auto [command, request] = add_command(app, action, "Verify", "tradeoff",
                                              "measure error against speed over the ladder of models", run_tradeoff);
  add_option(command, "--output", request.output, "directory of report, JSON and plot", {.type = "DIR"});
  add_option(command, "--scenes", request.scenes,
             "contacts of the mix, of which meshes take a third (default: 288, of pads 24)",
             {.least = 8, .most = 100000});
  add_option(command, "--seed", request.options.seed, "seed of the mix");
  add_option(command, "--pads", request.pads, "rungs of pads in place of lines: some ten seconds a contact and core");
  add_device_option(command, request.device);
  add_option(command, "--quiet", request.quiet, "no progress on stderr");
}

}  // namespace tactel::host
