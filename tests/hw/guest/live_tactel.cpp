// SPDX-License-Identifier: Apache-2.0

// tactel's record and monitor for the guest: the same commands.
#include <fmt/format.h>

#include "host/commands/command.h"

int main(int argc, char** argv) {
  CLI::App app;
  tactel::host::Action action;
  tactel::host::add_record_command(app, action);
  tactel::host::add_monitor_command(app, action);
  CLI11_PARSE(app, argc, argv);
  try {
    return action();
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return tactel::host::device_failed;
  }
}
