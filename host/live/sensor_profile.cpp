// SPDX-License-Identifier: Apache-2.0
#include "host/live/sensor_profile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "host/scenes/toml_table.h"
#include "hw/csv_format.h"
#include "hw/formats.h"
#include "hw/generic_format.h"

namespace tactel::host {
namespace {

using FormatMaker = std::function<std::unique_ptr<const hw::WireFormat>()>;

std::vector<std::uint8_t> read_bytes(TomlTable& in, const std::string& key) {
  std::vector<int> numbers;
  in.read(key, numbers, "an array of bytes, 0 to 255 (0x00 to 0xFF)");
  for (const int number : numbers)
    if (number < 0 || number > 255) in.refuse(key, "an array of bytes, 0 to 255 (0x00 to 0xFF)");
  return {numbers.begin(), numbers.end()};
}

int read_id(TomlTable& in, const std::string& key) {
  int id = 0;
  in.read(key, id, "a number from 0x0000 to 0xFFFF");
  if (id < 0 || id > 0xFFFF) in.refuse(key, "a number from 0x0000 to 0xFFFF");
  return id;
}

void read_device(const TomlFile& file, SensorProfile& profile) {
  TomlTable in(file, "device");
  in.read("name", profile.name, "a text");
  profile.usb.vendor = static_cast<std::uint16_t>(read_id(in, "vendor"));
  profile.usb.product = static_cast<std::uint16_t>(read_id(in, "product"));
  if (const auto choice = in.read_choice("transport", {"bulk", "cdc-acm", "ftdi"}))
    profile.usb.transport = std::array{hw::Transport::bulk, hw::Transport::cdc_acm, hw::Transport::ftdi}[*choice];
  in.read("interface", profile.usb.interface, "the number of a USB interface");
  in.read("endpoint", profile.usb.endpoint, "the address of an IN endpoint, 0x81 to 0x8F");
  if (in.has("endpoint") && (profile.usb.endpoint < 0x81 || profile.usb.endpoint > 0x8F))
    in.refuse("endpoint", "the address of an IN endpoint, 0x81 to 0x8F");
  in.read("baud", profile.usb.baud, "a whole number of bit/s above 0");
  if (profile.usb.baud <= 0) in.refuse("baud", "a whole number of bit/s above 0");
  profile.usb.start = read_bytes(in, "start");
  in.finish();
}

void read_field(TomlTable& in, const std::string& name, hw::HeaderField& field) {
  in.read(name + "_offset", field.offset, "a whole number of bytes from the frame's beginning");
  in.read(name + "_width", field.width, "1, 2, 4 or 8 bytes");
}

hw::GenericLayout read_layout(TomlTable& in) {
  hw::GenericLayout layout;
  layout.sync = read_bytes(in, "sync");
  layout.header = static_cast<int>(layout.sync.size());
  in.read("header", layout.header, "a whole number of bytes before the samples, sync included");
  read_field(in, "counter", layout.counter);
  read_field(in, "clock", layout.clock);
  in.read("clock_tick", layout.clock_tick, "a number of s above 0");
  in.read("channels", layout.channels, "a whole number of samples");
  if (const auto choice = in.read_choice("sample", {"i16", "u16", "i32", "f32", "f64"}))
    layout.sample = static_cast<hw::SampleType>(*choice);
  if (const auto choice = in.read_choice("byte_order", {"little", "big"})) layout.big_endian = *choice == 1;
  if (const auto choice = in.read_choice("checksum", {"none", "sum8", "sum16", "xor8", "crc16"}))
    layout.checksum = static_cast<hw::Checksum>(*choice);
  in.read("checksum_from", layout.checksum_from, "the offset of the first byte that the checksum covers");
  layout.trailer = read_bytes(in, "trailer");
  in.read("confirmations", layout.confirmations, "a whole number of frames");
  return layout;
}

FormatMaker read_format(const TomlFile& file, std::string& name) {
  const std::vector<std::string> kinds = {"generic", "glove", "papillarray", "anyskin", "agni", "paxini", "csv"};
  TomlTable in(file, "format");
  const auto kind = in.read_choice("kind", kinds);
  if (!kind) in.refuse_missing("kind", "generic, glove, papillarray, anyskin, agni, paxini or csv");
  name = kinds[*kind];
  FormatMaker maker;
  int sensors = 1, points = 1, channels = 0;
  if (kinds[*kind] == "papillarray" || kinds[*kind] == "paxini")
    in.read("sensors", sensors, "the number of connected sensors");
  if (kinds[*kind] == "paxini") in.read("points", points, "the number of points of a sensor");
  if (kinds[*kind] == "csv") in.read("channels", channels, "the number of numbers in a line, but for the time");
  switch (*kind) {
    case 0:
      maker = [layout = read_layout(in)] { return hw::generic_format(layout); };
      break;
    case 1:
      maker = hw::glove_format;
      break;
    case 2:
      maker = [sensors] { return hw::papillarray_format(sensors); };
      break;
    case 3:
      maker = hw::anyskin_format;
      break;
    case 4:
      maker = hw::agni_format;
      break;
    case 5:
      maker = [sensors, points] { return hw::paxini_format(sensors, points); };
      break;
    default:
      maker = [channels] { return hw::csv_format(channels); };
  }
  in.finish();
  return maker;
}

/// One number stands for all channels.
void read_numbers(TomlTable& in, const std::string& key, std::vector<double>& values, std::size_t channels) {
  std::vector<double> read;
  if (!in.read_one_or_more(key, read, "a number, or an array with one for each channel")) return;
  values = read.size() == 1 ? std::vector<double>(channels, read[0]) : read;
}

void read_calibration(const TomlFile& file, hw::Calibration& calibration, std::size_t channels) {
  TomlTable in(file, "calibration");
  read_numbers(in, "offset", calibration.offset, channels);
  read_numbers(in, "gain", calibration.gain, channels);
  read_numbers(in, "noise", calibration.noise, channels);
  in.finish();
}

void read_map(const TomlFile& file, hw::ChannelMap& map, std::size_t channels) {
  TomlTable in(file, "channels");
  in.read("normal", map.normal, "an array of channels from 0, one a tactel, -1 for none");
  map.shear.assign(map.normal.size(), -1);
  in.read("shear", map.shear, "an array of channels from 0, one a tactel, -1 for none");
  in.finish();
  if (map.normal.empty()) in.refuse_missing("normal", "an array of channels from 0, one a tactel, -1 for none");
  map.calibration = {std::vector<double>(channels, 0.0), std::vector<double>(channels, 1.0)};
  read_calibration(file, map.calibration, channels);
  map.validate(channels);
}

SensorProfile parse(const TomlFile& file) {
  TomlTable root(file, "");
  for (const char* table : {"device", "format", "channels", "calibration"}) root.expect_table(table);
  root.finish();
  SensorProfile profile;
  profile.text = file.text();
  read_device(file, profile);
  profile.format = read_format(file, profile.kind);
  try {
    read_map(file, profile.map, profile.format()->channels());
  } catch (const ValueError& error) {
    throw file.error(error);
  }
  return profile;
}

std::string glove_text() {
  std::vector<int> cells(64);
  for (int i = 0; i < 64; ++i) cells[static_cast<std::size_t>(i)] = i;
  return fmt::format(
      "[device]\nname = \"CITEC tactile glove\"\nvendor = 0x04D8\nproduct = 0x000A\ntransport = \"cdc-acm\"\n"
      "[format]\nkind = \"glove\"\n[channels]\nnormal = [{}]\n",
      fmt::join(cells, ", "));
}

}  // namespace

SensorProfile read_profile(const std::filesystem::path& path) { return parse(TomlFile(path)); }

SensorProfile parse_profile(const std::string& text, const std::string& source) {
  return parse(TomlFile(source, text));
}

SensorProfile built_in_profile(const std::string& name) {
  if (name != "glove")
    throw ConfigError("command line", "--source", "usb:" + name, "usb:glove, or usb:VID:PID with --profile");
  return parse_profile(glove_text(), "usb:glove");
}

void read_calibration(const std::filesystem::path& path, SensorProfile& profile) {
  const TomlFile file(path);
  TomlTable root(file, "");
  root.expect_table("calibration");
  root.finish();
  const std::size_t channels = profile.format()->channels();
  read_calibration(file, profile.map.calibration, channels);
  try {
    profile.map.validate(channels);
  } catch (const ValueError& error) {
    throw file.error(error);
  }
}

std::string calibration_text(const hw::Calibration& calibration) {
  std::string text = fmt::format(
      "[calibration]\noffset = [{}]  # the device's units, at rest\ngain = [{}]  # MPa by the device's unit\n",
      fmt::join(calibration.offset, ", "), fmt::join(calibration.gain, ", "));
  if (!calibration.noise.empty())
    text += fmt::format("noise = [{}]  # the device's units, standard deviation at rest\n",
                        fmt::join(calibration.noise, ", "));
  return text;
}

}  // namespace tactel::host
