#include <iostream>

#include "host/command.h"
#include "host/devices_command.h"

namespace tactel::host {

void add_devices_command(CLI::App& app, Action& action) {
  auto json = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("devices", "OpenCL devices, with the lanes and the precision that would be used");
  command->add_flag("--json", *json, "as JSON instead of a table");
  command->callback([json, &action] { action = [json] { return devices_command(*json, std::cout, std::cerr); }; });
}

}  // namespace tactel::host
