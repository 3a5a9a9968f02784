// tactel's record and monitor for the guest: the same commands, with the sources that need no solver.
#include <fmt/format.h>

#include "host/command.h"
#include "host/errors.h"
#include "host/open_source.h"
#include "hw/recording.h"
#include "hw/usb_source.h"

namespace tactel::host {

OpenSource open_source(const std::string& source, const std::string&, const std::string&) {
  if (source == "usb:glove") {
    SensorProfile profile = built_in_profile("glove");
    return {hw::open_usb(profile.usb), std::move(profile)};
  }
  const std::string replay = "replay:";
  if (!source.starts_with(replay)) throw ConfigError("command line", "--source", source, "usb:glove or replay:FILE");
  const std::string path = source.substr(replay.size());
  auto recording = std::make_unique<hw::ReplaySource>(path);
  SensorProfile profile = parse_profile(recording->description(), path);
  return {std::move(recording), std::move(profile)};
}

}  // namespace tactel::host

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
