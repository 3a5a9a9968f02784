#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <iostream>
#include <memory>
#include <vector>

#include "host/command.h"
#include "host/devices_command.h"
#include "host/errors.h"
#include "host/nearest_word.h"
#include "host/plot.h"
#include "hw/frame_source.h"

namespace {

using namespace tactel;
using namespace tactel::host;

/// Runs a command; says what went wrong and turns it into an exit code.
int guarded(const Action& action) {
  try {
    return action();
  } catch (const ConfigError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return wrong_input;
  } catch (const ValueError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return wrong_input;
  } catch (const PlotError& error) {
    fmt::print(stderr, "error: no plot: {}\n", error.what());
    return wrong_input;
  } catch (const hw::RecordingError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return wrong_input;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return device_failed;
  }
}

void add_devices_command(CLI::App& app, Action& action) {
  auto json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("devices", "OpenCL devices, with the lanes and precision that would be used");
  command->add_flag("--json", *json, "as JSON");
  command->callback([json, &action] { action = [json] { return devices_command(*json, std::cout, std::cerr); }; });
}

/// Says that a first word is no command, and which are; CLI11 would only say that one is missing.
bool refuse_unknown_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return false;
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
  if (std::ranges::find(known, argv[1]) != known.end()) return false;
  const std::string nearest = nearest_word(argv[1], known);
  fmt::print(stderr, "error: command line: command = {}: must be one of {}{}\n", argv[1], listed(known),
             nearest.empty() ? "" : "; did you mean " + nearest + "?");
  return true;
}

/// CLI11's complaint in the form of ours.
std::string parse_failure(const CLI::App* app, const CLI::Error& error) {
  return fmt::format("error: command line: {}\nsee {} --help\n", error.what(),
                     app->get_parent() ? "tactel " + app->get_name() : "tactel COMMAND");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "tactel: a tactile rubber skin in contact. Units: mm, MPa (N/mm2), N/mm (force per unit depth), s, degrees.",
      "tactel"};
  app.set_version_flag("--version", "tactel " TACTEL_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "Exit codes: 0 done, 2 wrong input, 3 device or hardware, 4 something did not meet its tolerance, 130 Ctrl-C.");
  Action action;
  add_devices_command(app, action);
  add_solve_command(app, action);
  add_generate_command(app, action);
  add_train_command(app, action);
  add_recall_command(app, action);
  add_reproduce_command(app, action);
  add_tradeoff_command(app, action);
  add_extremes_command(app, action);
  add_monitor_command(app, action);
  add_record_command(app, action);
  add_tare_command(app, action);
  app.failure_message(parse_failure);
  if (refuse_unknown_command(app, argc, argv)) return wrong_input;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? done : wrong_input;
  }
  return guarded(action);
}
