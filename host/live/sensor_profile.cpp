// SPDX-License-Identifier: Apache-2.0
#include "host/live/sensor_profile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>

#include "host/scenes/toml_table.h"
#include "host/support/nearest_word.h"
#include "hw/formats.h"
#include "hw/generic_format.h"
#include "nn/infer/grip_score.h"

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
  in.read("wait", profile.usb.wait, "s from opening until start is sent, 0 to 60");
  if (!(profile.usb.wait >= 0 && profile.usb.wait <= 60))
    in.refuse("wait", "s from opening until start is sent, 0 to 60");
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
  const auto count = [&in](const char* key, int usual, const char* words) {
    in.read(key, usual, words);
    return usual;
  };
  constexpr const char* connected = "the number of connected sensors";
  const std::vector<std::function<FormatMaker()>> makers = {
      [&] { return [layout = read_layout(in)] { return hw::generic_format(layout); }; },
      [&] { return hw::glove_format; },
      [&] { return std::bind_front(hw::papillarray_format, count("sensors", 1, connected)); },
      [&] { return std::bind_front(hw::anyskin_format, count("magnetometers", 5, "the number of magnetometers")); },
      [&] { return hw::agni_format; },
      [&] {
        const int sensors = count("sensors", 1, connected),
                  points = count("points", 1, "the number of points of a sensor");
        return std::bind_front(hw::paxini_format, sensors, points);
      },
      [&] {
        return std::bind_front(hw::csv_format,
                               count("channels", 0, "the number of numbers in a line, but for the time"));
      }};
  FormatMaker maker = makers[*kind]();
  in.finish();
  return maker;
}

/// One number stands for all channels. Returns whether the key is there.
bool read_numbers(TomlTable& in, const std::string& key, std::vector<double>& values, std::size_t channels) {
  std::vector<double> read;
  if (!in.read_one_or_more(key, read, "a number, or an array with one for each channel")) return false;
  values = read.size() == 1 ? std::vector<double>(channels, read[0]) : read;
  return true;
}

/// A gain without an offset, here or before, is that of raw counts, whose zero is to be measured.
void read_calibration(const TomlFile& file, hw::Calibration& calibration, std::size_t channels) {
  TomlTable in(file, "calibration");
  const bool offset = read_numbers(in, "offset", calibration.offset, channels);
  const bool gain = read_numbers(in, "gain", calibration.gain, channels);
  calibration.zero_told |= offset;
  calibration.has_zero = calibration.zero_told || (calibration.has_zero && !gain);
  read_numbers(in, "noise", calibration.noise, channels);
  in.read("moved", calibration.moved, "a number, above 0 and below 0.5, as tactel tare --hold writes it");
  in.read("slid", calibration.slid, "a number, above 0 and below 1, as tactel tare --hold --network writes it");
  in.finish();
}

/// What tactel tare wrote of grips that hold and slide.
void read_grips(const TomlFile& file, SensorProfile& profile) {
  constexpr const char* above = "a number above 0, as tactel tare writes it";
  const std::size_t n = infer::PadMoments(shape_of(profile, 0)).count(), numbers = n * (n + 1) / 2;
  TomlTable in(file, "hold"), slide(file, "slide");
  hw::RecordedHold hold;
  const std::string covariance =
      fmt::format("{} numbers of a positive definite matrix, as tactel tare --hold writes them", numbers);
  if (in.read("covariance", hold.covariance, covariance)) {
    const std::vector<float> given(hold.covariance.begin(), hold.covariance.end());
    if (given.size() != numbers || infer::whitening(given, n).empty()) in.refuse("covariance", covariance);
    for (const auto& [key, number] :
         {std::pair{"at", &hold.at}, {"seconds", &hold.seconds}, {"rate", &hold.rate}, {"margin", &hold.margin}})
      if (in.read(key, *number, above) && !(*number > 0 && std::isfinite(*number))) in.refuse(key, above);
    profile.map.calibration.hold = std::move(hold);
  }
  const std::size_t pads = std::max<std::size_t>(profile.pads.size(), 1);
  const std::string friction =
      fmt::format("Q / P of a slide, above 0, {}", pads > 1 ? fmt::format("of {} pads", pads) : "one number");
  std::vector<double>& frictions = profile.map.calibration.slide;
  if (slide.read_one_or_more("friction", frictions, friction) &&
      (frictions.size() != pads || !std::ranges::all_of(frictions, [](double k) { return k > 0 && k <= 1e3; })))
    slide.refuse("friction", friction);
  in.finish(), slide.finish();
}

void read_pads(const TomlFile& file, std::vector<PadLayout>& pads) {
  TomlTable in(file, "pad");
  const char* of_pad = "whole numbers, 1 to 128: [nx, ny] along x and y of each pad";
  const char* apart = "a number of mm above 0, or two [px, py] along x and y";
  if (in.keys().empty()) return;
  std::vector<int> sizes;
  in.read("tactels", sizes, of_pad);
  std::vector<double> pitch{0};
  if (in.read_one_or_more("pitch", pitch, apart) &&
      (pitch.size() > 2 || !std::ranges::all_of(pitch, [](double p) { return p > 0; })))
    in.refuse("pitch", apart);
  in.finish();
  if (sizes.empty()) in.refuse_missing("tactels", of_pad);
  if (sizes.size() % 2 != 0 || std::ranges::any_of(sizes, [](int n) { return n < 1 || n > 128; }))
    in.refuse("tactels", of_pad);
  for (std::size_t i = 0; i < sizes.size(); i += 2)
    pads.push_back({{sizes[i], sizes[i + 1]}, {pitch.front(), pitch.back()}});
}

void read_map(const TomlFile& file, SensorProfile& profile, std::size_t channels) {
  const char* words = "an array of channels from 0, one a tactel, -1 for none";
  hw::ChannelMap& map = profile.map;
  TomlTable in(file, "channels");
  in.read("normal", map.normal, words);
  if (profile.pads.empty()) {
    in.refuse_any({"shear_x", "shear_y"}, "left out without [pad]; a line has shear");
    map.shear.assign(map.normal.size(), -1);
    in.read("shear", map.shear, words);
  } else {
    in.refuse_any({"shear"}, "left out with [pad]; a pad has shear_x and shear_y");
    const bool x = in.read("shear_x", map.shear, words), y = in.read("shear_y", map.shear_y, words);
    if (x != y) in.refuse_missing(x ? "shear_y" : "shear_x", "given beside the shear of the other axis");
  }
  in.finish();
  if (map.normal.empty()) in.refuse_missing("normal", words);
  std::size_t of_pads = 0;
  for (const PadLayout& pad : profile.pads) of_pads += pad.count();
  if (!profile.pads.empty() && of_pads != map.normal.size())
    in.refuse("normal", fmt::format("one channel for each of the {} tactels of [pad]", of_pads));
  map.calibration = {std::vector<double>(channels, 0.0), std::vector<double>(channels, 1.0)};
  read_calibration(file, map.calibration, channels);
  map.validate(channels);
}

SensorProfile parse(const TomlFile& file) {
  TomlTable root(file, "");
  for (const char* table : {"device", "format", "pad", "channels", "calibration", "hold", "slide"})
    root.expect_table(table);
  root.finish();
  SensorProfile profile;
  profile.text = file.text();
  read_device(file, profile);
  profile.format = read_format(file, profile.kind);
  try {
    read_pads(file, profile.pads);
    read_map(file, profile, profile.format()->channels());
    read_grips(file, profile);
  } catch (const ValueError& error) {
    throw file.error(error);
  }
  return profile;
}

std::string glove_text() {
  std::vector<int> cells(64);
  std::iota(cells.begin(), cells.end(), 0);
  return fmt::format(
      "[device]\nname = \"CITEC tactile glove\"\nvendor = 0x04D8\nproduct = 0x000A\ntransport = \"cdc-acm\"\n"
      "[format]\nkind = \"glove\"\n[channels]\nnormal = [{}]\n",
      fmt::join(cells, ", "));
}

/// Covariance of the moments of holding hands (tactel::HeldGrip), of the quiet holds of twelve people.
constexpr double uskin_tremor[] = {
    0.00072848, 9.5204e-05,  6.6019e-05,  -0.00034778, -6.6874e-05, 0.00046961,  -4.0633e-05, -2.3102e-05, 7.0654e-05,
    9.0981e-05, -5.9109e-05, -3.8728e-06, -2.501e-05,  -4.0341e-06, 5.5551e-05,  8.353e-05,   1.2132e-05,  -7.8696e-05,
    -3.509e-05, -2.0655e-06, 3.5312e-05,  -1.5889e-05, 2.7881e-06,  -1.8181e-06, -7.8905e-06, 4.9237e-06,  -9.3196e-07,
    9.397e-06,  -8.9015e-05, -1.0169e-05, 2.4608e-05,  -1.3243e-05, 1.1073e-05,  -1.6708e-06, 6.2267e-06,  2.5678e-05};

/// Lines of x, y, z of each tactel, row by row. The gains have the signs alone: a pressed tactel counts upwards.
std::string uskin_text(int nx, int ny) {
  constexpr double nominal = 1e-5;  // MPa by a count
  hw::ChannelMap map;
  for (int tactel = 0; tactel < nx * ny; ++tactel) {
    map.shear.push_back(3 * tactel), map.shear_y.push_back(3 * tactel + 1), map.normal.push_back(3 * tactel + 2);
    map.calibration.gain.insert(map.calibration.gain.end(), {nominal, nominal, -nominal});
  }
  map.calibration.has_zero = false;
  map.calibration.hold.covariance.assign(std::begin(uskin_tremor), std::end(uskin_tremor));
  return fmt::format("[device]\nname = \"uSkin {} x {}\"\n[format]\nkind = \"csv\"\nchannels = {}\n", nx, ny,
                     3 * nx * ny) +
         channels_text(map, {{{nx, ny}, {4.7, 4.7}}}) + calibration_text(map.calibration);
}

/// The text of a built-in profile; empty for other names. Throws ConfigError for one that is nearly one of these.
std::string built_in_text(const std::string& name) {
  if (name == "glove") return glove_text();
  if (name == "uskin-4x4") return uskin_text(4, 4);
  if (name == "uskin-4x6") return uskin_text(4, 6);
  const std::string meant = did_you_mean(name, std::vector<std::string>{"glove", "uskin-4x4", "uskin-4x6"});
  if (!meant.empty() && !std::filesystem::exists(name))
    throw ConfigError("command line", "--profile", name, "a readable TOML file" + meant);
  return "";
}

}  // namespace

SensorProfile read_profile(const std::filesystem::path& path) {
  const std::string text = built_in_text(path.string());
  return text.empty() ? parse(TomlFile(path)) : parse_profile(text, path.string());
}

SensorProfile parse_profile(const std::string& text, const std::string& source) {
  return parse(TomlFile(source, text));
}

SensorProfile built_in_profile(const std::string& name) {
  if (name != "glove")
    throw ConfigError("command line", "--source", "usb:" + name, "usb:glove, or usb:VID:PID with --profile");
  return parse_profile(glove_text(), "usb:glove");
}

namespace {

/// The hold of all pads, where all have that one; else none, or the covariance of others.
hw::RecordedHold joined_hold(const std::vector<SensorProfile>& profiles) {
  hw::RecordedHold hold = profiles.front().map.calibration.hold;
  const auto same = [&](const SensorProfile& profile) {
    return profile.map.calibration.hold.covariance == hold.covariance && profile.map.calibration.hold.at == hold.at;
  };
  return std::ranges::all_of(profiles, same) ? hold : hw::RecordedHold{};
}

}  // namespace

infer::PadShape shape_of(const SensorProfile& profile, std::size_t pad) {
  const std::size_t axes = profile.map.places() / profile.map.tactels();
  if (profile.pads.empty()) return {profile.map.tactels(), axes, profile.map.tactels(), 1};
  const PadLayout& layout = profile.pads[pad];
  return {layout.count(), axes, static_cast<std::size_t>(layout.tactels[0]),
          layout.pitch[0] > 0 ? layout.pitch[1] / layout.pitch[0] : 1};
}

SensorProfile joined_profile(const std::vector<SensorProfile>& profiles) {
  hw::ChannelMap map;
  std::vector<PadLayout> pads;
  std::size_t channels = 0;
  const SensorProfile& first = profiles.front();
  for (const SensorProfile& profile : profiles) {
    const bool alike = !profile.pads.empty() && profile.kind == "csv" && profile.pads[0].pitch == first.pads[0].pitch &&
                       profile.map.shear.empty() == first.map.shear.empty();
    if (!alike)
      throw ConfigError("command line", "--profile", profile.name.empty() ? profile.kind : profile.name,
                        "with several profiles: pads in lines of numbers (format.kind csv, [pad]), of one pitch and "
                        "with the same axes");
    for (const auto& [to, from] : {std::pair{&map.normal, &profile.map.normal},
                                   {&map.shear, &profile.map.shear},
                                   {&map.shear_y, &profile.map.shear_y}})
      for (const int channel : *from) to->push_back(channel < 0 ? -1 : channel + static_cast<int>(channels));
    const hw::Calibration& calibration = profile.map.calibration;
    const std::pair<std::vector<double>*, const std::vector<double>*> numbers[] = {
        {&map.calibration.offset, &calibration.offset},
        {&map.calibration.gain, &calibration.gain},
        {&map.calibration.noise, &calibration.noise}};
    for (const auto& [to, from] : numbers) to->insert(to->end(), from->begin(), from->end());
    map.calibration.has_zero &= calibration.has_zero;
    pads.insert(pads.end(), profile.pads.begin(), profile.pads.end());
    channels += profile.format()->channels();
  }
  map.calibration.hold = joined_hold(profiles);
  for (const SensorProfile& profile : profiles) {
    const std::vector<double>& slide = profile.map.calibration.slide;
    map.calibration.slide.insert(map.calibration.slide.end(), slide.begin(), slide.end());
  }
  if (map.calibration.slide.size() != pads.size()) map.calibration.slide.clear();
  if (map.calibration.noise.size() != channels) map.calibration.noise.clear();
  for (const auto threshold : {&hw::Calibration::moved, &hw::Calibration::slid}) {
    const auto of_pad = [&](const SensorProfile& profile) { return profile.map.calibration.*threshold; };
    const bool known = std::ranges::all_of(profiles, [&](const SensorProfile& profile) { return of_pad(profile) > 0; });
    map.calibration.*threshold = known ? of_pad(*std::ranges::max_element(profiles, {}, of_pad)) : 0;
  }
  return parse_profile(fmt::format("[format]\nkind = \"csv\"\nchannels = {}\n", channels) + channels_text(map, pads) +
                           calibration_text(map.calibration),
                       "--profile");
}

std::string channels_text(const hw::ChannelMap& map, const std::vector<PadLayout>& pads) {
  std::string text;
  if (!pads.empty()) {
    std::vector<int> sizes;
    for (const PadLayout& pad : pads) sizes.insert(sizes.end(), pad.tactels.begin(), pad.tactels.end());
    text = fmt::format("[pad]\ntactels = {}\n", sizes);
    if (pads[0].pitch[0] > 0) text += fmt::format("pitch = {}\n", pads[0].pitch);
  }
  text += fmt::format("[channels]\nnormal = {}\n", map.normal);
  if (!map.shear.empty()) text += fmt::format("shear{} = {}\n", pads.empty() ? "" : "_x", map.shear);
  if (!map.shear_y.empty()) text += fmt::format("shear_y = {}\n", map.shear_y);
  return text;
}

void read_calibration(const std::filesystem::path& path, SensorProfile& profile) {
  const TomlFile file(path);
  TomlTable root(file, "");
  for (const char* table : {"calibration", "hold", "slide"}) root.expect_table(table);
  root.finish();
  const std::size_t channels = profile.format()->channels();
  read_calibration(file, profile.map.calibration, channels);
  read_grips(file, profile);
  try {
    profile.map.validate(channels);
  } catch (const ValueError& error) {
    throw file.error(error);
  }
}

std::string calibration_text(const hw::Calibration& calibration) {
  std::string text = "[calibration]\n";
  if (calibration.has_zero)
    text += fmt::format("offset = [{}]  # the device's units, at rest\n", fmt::join(calibration.offset, ", "));
  text += fmt::format("gain = [{}]  # MPa by the device's unit\n", fmt::join(calibration.gain, ", "));
  if (!calibration.noise.empty())
    text += fmt::format("noise = [{}]  # the device's units, standard deviation at rest\n",
                        fmt::join(calibration.noise, ", "));
  if (calibration.moved > 0)
    text += fmt::format("moved = {}  # 1.2 times the largest of a recorded hold\n", calibration.moved);
  if (calibration.slid > 0)
    text += fmt::format("slid = {}  # 1.2 times a network's largest answer to it\n", calibration.slid);
  if (const hw::RecordedHold& hold = calibration.hold; !hold.covariance.empty()) {
    text += fmt::format("[hold]\ncovariance = [{:.6g}]\n", fmt::join(hold.covariance, ", "));
    if (hold.at > 0)
      text += fmt::format(
          "at = {:.6g}  # of the norm by it\nseconds = {:.4g}\nrate = {:.4g}  # Hz\nmargin = {:.4g}  # at over the "
          "largest of the hold\n",
          hold.at, hold.seconds, hold.rate, hold.margin);
  }
  if (!calibration.slide.empty())
    text += fmt::format("[slide]\nfriction = [{:.6g}]  # Q / P with its torque, of each pad\n",
                        fmt::join(calibration.slide, ", "));
  return text;
}

}  // namespace tactel::host
