// SPDX-License-Identifier: Apache-2.0
#include "host/live/open_source.h"

#include <charconv>
#include <optional>

#include "host/live/csv_source.h"
#include "host/live/simulated_sensor.h"
#include "host/live/source_options.h"
#include "host/support/bounded_file.h"
#include "host/support/errors.h"
#include "hw/recording.h"
#include "hw/usb_source.h"

namespace tactel::host {
namespace {

constexpr const char* allowed_sources =
    "usb:glove, usb:VID:PID with --profile, csv:FILE or csv:- with --profile, replay:FILE or "
    "'simulate:SCENE.toml?rate=100'";

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
  SensorProfile own = profile.empty() ? parse_profile(source->description(), options.path()) : read_profile(profile);
  return {std::move(source), std::move(own)};
}

OpenSource open_csv(const std::string& text, const std::string& profile) {
  SourceOptions options(text);
  int paced = 0;
  options.read("paced", paced);
  options.finish();
  if (profile.empty())
    throw ConfigError("command line", "--profile", "(missing)", "given with csv: a profile whose format.kind is csv");
  SensorProfile own = read_profile(profile);
  if (own.kind != "csv") throw ConfigError(profile, "format.kind", own.kind, "csv, for --source csv:");
  return {std::make_unique<CsvSource>(options.path(), own.format()->channels(), paced != 0), std::move(own)};
}

OpenSource open(const std::string& kind, const std::string& rest, const std::string& profile) {
  if (kind == "replay") return open_replay(rest, profile);
  if (kind == "usb") return open_usb_source(rest, profile);
  if (kind == "csv") return open_csv(rest, profile);
  if (kind != "simulate") throw ConfigError("command line", "--source", kind + ":" + rest, allowed_sources);
  if (!profile.empty())
    throw ConfigError("command line", "--profile", profile, "left out with simulate:, which brings its own");
  auto sensor = open_simulation(rest);
  SensorProfile own = parse_profile(sensor->profile_text(), "simulated sensor");
  return {std::move(sensor), std::move(own)};
}

}  // namespace

OpenSource open_source(const std::string& source, const std::string& profile, const std::string& calibration) {
  const auto colon = source.find(':');
  if (has_nul(source)) throw ConfigError("command line", "--source", source, "without a NUL byte");
  if (colon == std::string::npos || colon + 1 == source.size())
    throw ConfigError("command line", "--source", source, allowed_sources);
  OpenSource opened = open(source.substr(0, colon), source.substr(colon + 1), profile);
  if (!calibration.empty()) read_calibration(calibration, opened.profile);
  return opened;
}

}  // namespace tactel::host
