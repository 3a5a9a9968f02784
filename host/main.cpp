#include <fmt/format.h>

#include <exception>

#include "host/command.h"
#include "host/errors.h"
#include "host/plot.h"

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
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return device_failed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "tactel: a tactile rubber skin in contact. Units: mm, MPa (N/mm2), N/mm (force per unit depth), s, degrees.",
      "tactel"};
  app.set_version_flag("--version", "tactel " TACTEL_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer("Exit codes: 0 done, 2 wrong input, 3 device or hardware, 4 something did not meet its tolerance.");
  Action action;
  add_solve_command(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? done : wrong_input;
  }
  return guarded(action);
}
