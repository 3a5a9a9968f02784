// SPDX-License-Identifier: Apache-2.0

#include "host/live/open_source.h"

#include <charconv>
#include <optional>

#include "host/live/csv_source.h"
#include "host/live/simulated_sensor.h"
#include "host/support/bounded_file.h"
#include "host/support/errors.h"
#include "host/support/nearest_word.h"
#include "hw/recording.h"
#include "hw/serial_port.h"
#include "hw/usb_source.h"

namespace tactel::host {
namespace {

constexpr const char* allowed_sources =
    "usb:glove, usb:VID:PID with --profile, 'serial:/dev/ttyACM0?baud=115200' with --profile, csv:FILE or csv:- with "
    "--profile, replay:FILE or 'simulate:SCENE.toml?rate=100'";

/// "04D8" as a number; none for what is no such number.
std::optional<std::uint16_t> hexadecimal(const std::string& text) {
  std::uint16_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

SensorProfile usb_profile(const std::string& name, const std::string& file) {
  const auto colon = name.find(':');
  if (colon == std::string::npos) return file.empty() ? built_in_profile(name) : read_profile(file);
  const auto vendor = hexadecimal(name.substr(0, colon)), product = hexadecimal(name.substr(colon + 1));
  if (!vendor || !product) throw ConfigError("command line", "--source", "usb:" + name, allowed_sources);
  if (file.empty())
    throw ConfigError("command line", "--profile", "(missing)", "given with usb:VID:PID: a device profile (TOML)");
  SensorProfile profile = read_profile(file);
  if (profile.kind == "csv") throw ConfigError(file, "format.kind", profile.kind, "that of the device's bytes");
  profile.usb.vendor = *vendor, profile.usb.product = *product;
  return profile;
}

/// Which device this is, where others fit as well.
std::string note_of(const hw::UsbDevice& wanted, const hw::UsbChoice& choice) {
  std::string others;
  for (const hw::UsbChoice::Other& other : choice.others) {
    const bool fits = (wanted.port.empty() || wanted.port == other.place.port) &&
                      (wanted.serial.empty() || wanted.serial == other.place.serial);
    if (!fits) continue;
    others += (others.empty() ? "" : ", ") + place_text(other.place) + (other.refusal.empty() ? "" : " (not free)");
  }
  if (others.empty()) return "";
  return "reads the device at " + place_text(choice.taken) + "; also connected: " + others +
         "; --source 'usb:...?serial=NUMBER' or '?port=PORT' selects one";
}

OpenSource open_usb_source(const std::string& given, const std::string& profile) {
  SourceOptions options(given);
  SensorProfile of_device = usb_profile(options.path(), profile);
  options.read("serial", of_device.usb.serial);
  options.read("port", of_device.usb.port);
  options.finish();
  auto source = hw::open_usb(of_device.usb);
  std::string note = note_of(of_device.usb, source->choice());
  return {std::move(source), std::move(of_device), std::move(note)};
}

OpenSource open_replay(const std::string& text, const std::string& profile) {
  SourceOptions options(text);
  int paced = 0;
  options.read("paced", paced);
  options.finish();
  auto source = std::make_unique<hw::ReplaySource>(options.path(), paced != 0);
  SensorProfile used = profile.empty() ? parse_profile(source->description(), options.path()) : read_profile(profile);
  return {std::move(source), std::move(used)};
}

/// The profiles of a line of numbers as one, each with its calibration where there is one for each.
SensorProfile read_profiles(Files names, Files calibrations) {
  std::vector<SensorProfile> profiles;
  for (std::size_t i = 0; i < names.size(); ++i) {
    profiles.push_back(read_profile(names[i]));
    if (profiles[i].kind != "csv")
      throw ConfigError(names[i], "format.kind", profiles[i].kind, "csv, for --source csv:");
    if (calibrations.size() > 1) read_calibration(calibrations[i], profiles[i]);
  }
  return profiles.size() == 1 ? std::move(profiles[0]) : joined_profile(profiles);
}

OpenSource open_csv(const std::string& text, Files profiles, Files calibrations) {
  SourceOptions options(text);
  int paced = 0;
  std::optional<int> sensor;
  options.read("paced", paced);
  if (int id = 0; options.read("sensor", id)) sensor = id;
  options.finish();
  if (profiles.empty())
    throw ConfigError("command line", "--profile", "(missing)",
                      "given with csv: uskin-4x4, uskin-4x6, or a profile whose format.kind is csv");
  SensorProfile joined = read_profiles(profiles, calibrations);
  return {std::make_unique<CsvSource>(options.path(), joined.format()->channels(), paced != 0, sensor),
          std::move(joined)};
}

/// Lines of numbers, or the bytes of another format.
OpenSource open_serial(const std::string& text, Files profiles, Files calibrations) {
  SourceOptions options(text);
  std::optional<int> baud;
  if (int given = 0; options.read("baud", given)) baud = given;
  options.finish();
  if (profiles.empty())
    throw ConfigError("command line", "--profile", "(missing)", "given with serial:, a profile of the device's bytes");
  const std::string& path = options.path();
  SensorProfile first = read_profile(profiles[0]);
  const hw::SerialSettings settings{baud.value_or(first.usb.baud), first.usb.start, first.usb.wait};
  if (profiles.size() == 1 && first.kind != "csv")
    return {std::make_unique<hw::SerialSource>(path, settings), std::move(first)};
  SensorProfile joined = read_profiles(profiles, calibrations);
  return {
      std::make_unique<CsvSource>(std::make_unique<hw::SerialPort>(path, settings), path, joined.format()->channels()),
      std::move(joined)};
}

OpenSource open(const std::string& kind, const std::string& rest, Files profiles, Files calibrations) {
  if (kind == "csv") return open_csv(rest, profiles, calibrations);
  if (kind == "serial") return open_serial(rest, profiles, calibrations);
  if (profiles.size() > 1)
    throw ConfigError("command line", "--profile", profiles[1],
                      "given once with " + kind + ":; several profiles are of the pads in a line of csv: or serial:");
  const std::string profile = profiles.empty() ? "" : profiles[0];
  if (kind == "replay") return open_replay(rest, profile);
  if (kind == "usb") return open_usb_source(rest, profile);
  if (kind != "simulate")
    throw ConfigError(
        "command line", "--source", kind + ":" + rest,
        allowed_sources + did_you_mean(kind, std::vector<std::string>{"usb", "serial", "csv", "replay", "simulate"}));
  if (!profile.empty())
    throw ConfigError("command line", "--profile", profile, "left out with simulate:, which brings its own");
  auto sensor = open_simulation(rest);
  SensorProfile simulated = parse_profile(sensor->profile_text(), "simulated sensor");
  const SimulatedSensor* played = sensor.get();
  return {std::move(sensor), std::move(simulated), "",
          [played](std::uint64_t n) { return played->true_slip_index(n); }};
}

}  // namespace

OpenSource open_source(const std::string& source, const std::string& profile, const std::string& calibration) {
  return open_source(source, Files(&profile, profile.empty() ? 0 : 1),
                     Files(&calibration, calibration.empty() ? 0 : 1));
}

OpenSource open_source(const std::string& source, Files profiles, Files calibrations) {
  const auto colon = source.find(':');
  if (has_nul(source)) throw ConfigError("command line", "--source", source, "without a NUL byte");
  if (colon == std::string::npos || colon + 1 == source.size())
    throw ConfigError("command line", "--source", source, allowed_sources);
  if (calibrations.size() > 1 && calibrations.size() != profiles.size())
    throw ConfigError("command line", "--calibration", calibrations[1], "given once, or once for each --profile");
  OpenSource opened = open(source.substr(0, colon), source.substr(colon + 1), profiles, calibrations);
  if (calibrations.size() == 1) read_calibration(calibrations[0], opened.profile);
  return opened;
}

}  // namespace tactel::host
