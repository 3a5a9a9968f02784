// SPDX-License-Identifier: Apache-2.0
#include "host/commands/live/sensor_session.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>

#include "host/commands/add_option.h"
#include "host/support/terminal.h"

namespace tactel::host {
namespace {

/// `name`: as CLI11 and its option errors call the numbers.
CLI::Validator finite_number(const char* name, const std::string& allowed, bool (*is_allowed)(double)) {
  return CLI::Validator(
      [=](const std::string& text) -> std::string {
        double value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        const bool number = error == std::errc{} && end == text.data() + text.size();
        return number && std::isfinite(value) && is_allowed(value) ? ""
                                                                   : text + ": must be a finite number, " + allowed;
      },
      name);
}

}  // namespace

const CLI::Validator& positive_number() {
  static const CLI::Validator validator = finite_number("above 0", "above 0", [](double value) { return value > 0; });
  return validator;
}

const CLI::Validator& not_negative_number() {
  static const CLI::Validator validator =
      finite_number("NONNEGATIVE", "0 or more", [](double value) { return value >= 0; });
  return validator;
}

void add_sensor_options(CLI::App& command, SensorRequest& request) {
  add_option(command, "--source", request.source,
             "usb:glove, usb:VID:PID, 'usb:...?serial=NUMBER', serial:/dev/ttyACM0, csv:FILE, csv:- (standard input), "
             "replay:FILE or 'simulate:SCENE.toml?rate=100' (docs/sensors.md)",
             {.type = "SOURCE"})
      ->required();
  add_option(command, "--profile", request.profiles,
             "profile of the device: a file of wire format and channels, uskin-4x4 or uskin-4x6; repeatable, one for "
             "each pad in a line of csv:",
             {.type = "FILE.toml"});
  add_option(command, "--calibration", request.calibrations,
             "offsets and gains instead of the profile's, see tactel tare; once, or for each --profile",
             {.type = "FILE.toml"});
}

OpenSource open_for(const SensorRequest& request) {
  OpenSource opened = open_source(request.source, request.profiles, request.calibrations);
  if (!opened.note.empty() && !request.quiet) say("note: " + opened.note);
  return opened;
}

void say_if_cut_short(const SensorRequest& request, const hw::FrameSource& source) {
  if (request.quiet) return;
  if (const std::uint64_t bad = source.counts().bad; bad > 0)
    print_warning(
        fmt::format("{} line{} left out, the first: {}", bad, bad == 1 ? " was" : "s were", source.first_bad()));
  if (source.cut_short()) print_warning(request.source + " was cut off: its end is missing");
}

void say_if_nothing_decoded(const SensorRequest& request, const hw::FrameSource& source,
                            const hw::DecoderCounts& counts) {
  if (counts.frames > 0 || request.quiet) return;
  const std::uint64_t bytes = source.counts().bytes;
  if (bytes == 0)
    print_warning(request.source + ": no byte came, so there is no frame; is the sensor on?");
  else
    print_warning(request.source + ": no frame was found in " + std::to_string(bytes) +
                  " bytes; the wire format of the profile must be that of the sensor (docs/profiles.md)");
}

void say(const std::string& text) {
  std::fputs((text + "\n").c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace tactel::host
