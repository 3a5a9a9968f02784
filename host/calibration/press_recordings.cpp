// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/press_recordings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include "fem/value_error.h"
#include "host/calibration/median.h"
#include "host/live/frame_reader.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/toml_table.h"
#include "hw/recording.h"
#include "hw/tare.h"

namespace tactel::host {
namespace {

constexpr double poisson_reach = 0.04, most_poisson = 0.4995;
constexpr std::size_t fewest_frames = 4;  ///< of a window, for its noise
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Readings around the time of a load step, while the indenter rests, by transducer; of one without a channel there are
/// none.
using Window = std::vector<hw::ChannelRest>;

double mean(const hw::ChannelRest& rest) { return rest.readings > 0 ? rest.mean : unknown; }
double noise(const hw::ChannelRest& rest) { return rest.readings < fewest_frames ? unknown : rest.noise; }
double half_step(const hw::ChannelRest& rest) { return rest.step > 0 ? rest.step / 2 : unknown; }
/// Of the mean: noise below half a step is not averaged out.
double noise_of_mean(const hw::ChannelRest& rest) {
  if (rest.readings < fewest_frames) return unknown;
  return rest.noise > rest.step / 2 ? rest.noise / std::sqrt(static_cast<double>(rest.readings)) : rest.step / 2;
}

/// Windows of so many s around these times of a recording.
std::vector<Window> read_windows(const std::filesystem::path& path, const SensorProfile& profile,
                                 const std::vector<double>& times, double width, std::size_t transducers,
                                 TomlTable& in) {
  hw::Decoder decoder(profile.format());
  std::vector<hw::Tare> frames(times.size(), hw::Tare(decoder.format().channels()));
  hw::ReplaySource source(path);
  std::optional<double> first;
  read_frames(source, decoder, {.frame = [&](const hw::DecodedFrame& frame, double arrival) {
                if (!first) first = arrival;
                for (std::size_t k = 0; k < times.size(); ++k)
                  if (std::abs(arrival - *first - times[k]) <= width / 2) frames[k].add(frame.values);
              }});
  std::vector<Window> windows(times.size(), Window(transducers));
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (frames[k].frames() == 0)
      in.refuse("times", fmt::format("times within the recording {}: {:g} s has no frame", path.string(), times[k]));
    for (std::size_t i = 0; i < transducers; ++i)
      if (const int channel = profile.map.channel(i); channel >= 0)
        windows[k][i] = frames[k].channel(static_cast<std::size_t>(channel));
  }
  return windows;
}

/// When the press moves. Between the windows over which it is read, unless the file tells.
PressTiming read_timing(TomlTable& in, const std::vector<double>& times, double window) {
  PressTiming timing{.time = times};
  for (std::size_t k = 0; k < times.size(); ++k) {
    timing.begin.push_back(k > 0 ? times[k - 1] + window / 2 : 0);
    timing.end.push_back(times[k] - window / 2);
  }
  in.read("begin", timing.begin, "an array of s since the first frame, when the motion to each load step begins");
  in.read("end", timing.end, "an array of s since the first frame, when the motion to each load step ends");
  return timing;
}

/// Number of load steps, and whether they end by sliding alone.
std::pair<std::size_t, bool> load_steps_of(const AnyScene& scene) {
  if (const auto* pad = std::get_if<fem::PadScene>(&scene)) return {fem::pad_targets(pad->load).size(), false};
  const fem::LoadPath path = fem::load_path(std::get<fem::Scene>(scene).load);
  return {path.steps.size(), path.until_sliding};
}

/// Whether the profile has the channels of a scene's tactels.
bool has_channels(const SensorProfile& profile, const AnyScene& scene) {
  const auto* pad = std::get_if<fem::PadScene>(&scene);
  if (pad == nullptr)
    return profile.pads.empty() && static_cast<std::size_t>(tactels_of(scene)) == profile.map.tactels();
  return profile.pads.size() == 1 && profile.pads.front().tactels == pad->sensor.tactels &&
         profile.map.places() == static_cast<std::size_t>(channels_of(scene));
}

/// What a scene with its channels is.
std::string scene_with_channels(const SensorProfile& profile) {
  if (profile.pads.empty())
    return fmt::format("a scene of a line with the profile's {} tactels", profile.map.tactels());
  if (profile.pads.size() > 1) return "used with the profile of one pad: calibrate pads one by one";
  const auto [columns, rows] = profile.pads.front().tactels;
  return fmt::format("a scene of a pad with the profile's {} x {} tactels of {} axes", columns, rows,
                     profile.map.places() / profile.map.tactels());
}

/// Reads a press, and adds its windows.
KnownPress read_press(const TomlFile& file, const std::string& name, const SensorProfile& profile,
                      std::vector<Window>& windows) {
  TomlTable in(file, name);
  std::string scene_file, recording;
  std::vector<double> times, P;
  double window = 0.1;
  in.read("scene", scene_file, "a scene file");
  in.read("recording", recording, "a file of tactel record");
  in.read("times", times, "an array of s since the first frame, one for each load step");
  in.read("P", P, "an array of N/mm (pads: N), one for each load step");
  in.read("window", window, "s above 0, over which frames are averaged");
  PressTiming timing = read_timing(in, times, window);
  in.finish();
  if (scene_file.empty()) in.refuse_missing("scene", "a scene file");
  if (recording.empty()) in.refuse_missing("recording", "a file of tactel record");
  if (times.empty()) in.refuse_missing("times", "an array of s since the first frame, one for each load step");
  double longest = 2 * times.front();
  for (std::size_t k = 1; k < times.size(); ++k) longest = std::min(longest, times[k] - times[k - 1]);
  if (!(longest > 0)) in.refuse("times", "s since the first frame, above 0, each later than the one before");
  if (!(window > 0 && window <= longest))
    in.refuse("window", fmt::format("s above 0, over which frames are averaged; at most {:g}, so that windows begin "
                                    "with the recording and do not overlap",
                                    longest));
  const std::filesystem::path folder = file.path().parent_path();
  KnownPress press{
      .name = name, .scene = read_any_scene(folder / scene_file), .readings = {}, .P = {}, .timing = std::move(timing)};
  const auto [load_steps, until_sliding] = load_steps_of(press.scene);
  if (until_sliding || load_steps != times.size())
    in.refuse("times", fmt::format("as long as the scene has load steps, {}", load_steps));
  if (!P.empty() && P.size() != times.size()) in.refuse("P", fmt::format("as long as times, {}", times.size()));
  if (std::ranges::any_of(P, [](double force) { return force <= 0; }))
    in.refuse("P", "an array of N/mm (pads: N) above 0; left out where the force was not measured");
  try {
    press.timing.validate(times.size());
  } catch (const ValueError& error) {
    throw file.error(ValueError(name + "." + error.key, error.value, error.allowed));
  }
  if (!has_channels(profile, press.scene)) in.refuse("scene", scene_with_channels(profile));
  const Eigen::Index transducers = channels_of(press.scene);
  const std::vector<Window> read =
      read_windows(folder / recording, profile, times, window, static_cast<std::size_t>(transducers), in);
  press.readings.resize(static_cast<Eigen::Index>(read.size()), transducers);
  for (Eigen::Index k = 0; k < press.readings.rows(); ++k)
    std::ranges::transform(read[static_cast<std::size_t>(k)], press.readings.row(k).begin(), mean);
  windows.insert(windows.end(), read.begin(), read.end());
  press.P = Eigen::Map<const Eigen::VectorXd>(P.data(), static_cast<Eigen::Index>(P.size()));
  return press;
}

/// Returns `measure` of those `number`s of the windows that are known, for each transducer; NaN where there are none.
Eigen::VectorXd by_transducer(const std::vector<Window>& windows, double (*number)(const hw::ChannelRest&),
                              double (*measure)(std::vector<double>)) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(windows.front().size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    std::vector<double> values;
    for (const Window& window : windows)
      if (const double value = number(window[static_cast<std::size_t>(i)]); std::isfinite(value))
        values.push_back(value);
    result[i] = values.empty() ? unknown : measure(std::move(values));
  }
  return result;
}

/// Standard deviations of single readings: as tare has them, half a step at least.
Eigen::VectorXd noise_of_frames(const std::vector<Window>& windows) {
  const Eigen::VectorXd least =
      by_transducer(windows, half_step, [](std::vector<double> steps) { return std::ranges::min(steps); });
  return by_transducer(windows, noise, median).binaryExpr(least, [](double of_frame, double half_step) {
    return half_step > of_frame ? half_step : of_frame;
  });
}

/// Of means over windows: 0 where a column has no number; empty where none has.
Eigen::VectorXd noise_of_means(const std::vector<Window>& windows) {
  const Eigen::VectorXd result = by_transducer(windows, noise_of_mean, median);
  return result.array().isNaN().all() ? Eigen::VectorXd() : Eigen::VectorXd(result.array().isNaN().select(0, result));
}

bool same_sensor(const fem::Sensor& a, const fem::Sensor& b) {
  return a.length == b.length && a.thickness == b.thickness && a.poisson == b.poisson && a.young == b.young &&
         a.tactels == b.tactels && a.span() == b.span() && a.tactel_width == b.tactel_width;
}

bool same_sensor(const fem::PadSensor& a, const fem::PadSensor& b) { return a == b; }
/// A line and a pad.
bool same_sensor(const auto&, const auto&) { return false; }

}  // namespace

CalibrationOptions read_fit(const TomlFile& file) {
  CalibrationOptions options;
  TomlTable fit(file, "fit"), transducer(file, "transducer");
  fit.read("poisson", options.fit_poisson, "true or false");
  fit.read("thickness", options.fit_thickness, "true or false");
  fit.read("shift", options.fit_shift, "true or false");
  fit.read("time_constant", options.fit_time_constant, "true or false");
  fit.read("friction", options.friction_deviation, "standard deviation of each press's friction, relative, 0 to 1");
  fit.read("force_noise", options.force_noise, "standard deviation of P over P, above 0, at most 1");
  fit.read("lowest_reading", options.lowest_reading, "the lowest reading of the converter");
  fit.read("highest_reading", options.highest_reading, "the highest reading of the converter");
  fit.finish();
  transducer.read("time_constant", options.time_constant, "s above 0, of the charge amplifiers");
  transducer.finish();
  if (!(options.time_constant > 0)) transducer.refuse("time_constant", "s above 0, of the charge amplifiers");
  try {
    options.validate();
  } catch (const ValueError& error) {
    throw file.error(ValueError("fit." + error.key, error.value, error.allowed));
  }
  return options;
}

void require_same_sensor(const TomlFile& file, const std::string& name, const AnyScene& scene, const std::string& first,
                         const AnyScene& expected) {
  if (!std::visit([](const auto& a, const auto& b) { return same_sensor(a.sensor, b.sensor); }, scene, expected))
    throw ConfigError(file.path().string(), name + ".scene", "another sensor", "a scene with the sensor of " + first);
}

SensorCalibration calibrate_sensor(const PressRecordings& recordings, int threads) {
  CalibrationOptions options = recordings.options;
  options.threads = threads;
  const AnyScene& scene = recordings.presses.front().scene;
  const SensorState start = std::visit(
      [](const auto& press) {
        return SensorState{std::log(press.sensor.young), press.sensor.poisson, press.sensor.thickness};
      },
      scene);
  if (std::holds_alternative<fem::PadScene>(scene)) return calibrate_pad(recordings.presses, start, options);
  const fem::SensorFamily family = calibration_family(std::get<fem::Scene>(scene).sensor, options);
  return calibrate_sensor(family, recordings.presses, start, options);
}

fem::SensorFamily calibration_family(const fem::Sensor& sensor, const CalibrationOptions& options) {
  const double reach = options.fit_poisson ? poisson_reach : 0;
  return fem::SensorFamily({.poisson_low = std::max(0.0, sensor.poisson - reach),
                            .poisson_high = reach > 0 ? std::min(sensor.poisson + reach, most_poisson) : sensor.poisson,
                            .longest = std::max(fem::SensorRange{}.longest, 1.3 * sensor.length / sensor.thickness),
                            .tactels = sensor.tactels});
}

PressRecordings read_press_recordings(const std::filesystem::path& path, const SensorProfile& profile) {
  const TomlFile file(path);
  PressRecordings result{.presses = {}, .options = read_fit(file)};
  TomlTable root(file, "");
  std::vector<Window> windows;
  for (const std::string& name : root.keys()) {
    root.expect_table(name);
    if (name != "fit" && name != "transducer") result.presses.push_back(read_press(file, name, profile, windows));
  }
  root.finish();
  if (result.presses.empty())
    throw file.error("press", nullptr, "at least one table of a press: scene, recording, times");
  const KnownPress& first = result.presses.front();
  for (const KnownPress& press : result.presses)
    require_same_sensor(file, press.name, press.scene, first.name, first.scene);
  result.options.rest_noise = noise_of_means(windows);
  result.noise = noise_of_frames(windows);
  return result;
}

std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  return text;
}

hw::Calibration merged_calibration(const SensorProfile& profile, const SensorCalibration& found,
                                   const Eigen::VectorXd& noise) {
  hw::Calibration calibration = profile.map.calibration;
  if (calibration.noise.empty() && !noise.array().isNaN().all()) calibration.noise.assign(calibration.gain.size(), 0);
  for (std::size_t i = 0; i < found.gain.size(); ++i) {
    const int place = profile.map.channel(i);
    if (place < 0) continue;
    const auto channel = static_cast<std::size_t>(place);
    const double of_frame = noise[static_cast<Eigen::Index>(i)];
    if (std::isfinite(of_frame)) calibration.noise[channel] = of_frame;
    if (!std::isfinite(found.gain[i].value)) continue;
    calibration.gain[channel] = found.gain[i].value;
    calibration.offset[channel] = found.offset[i].value;
    calibration.has_zero = true;
  }
  return calibration;
}

std::string calibrated_profile(const SensorProfile& profile, const hw::Calibration& calibration,
                               const std::vector<std::string>& remarks) {
  std::istringstream lines(profile.text);
  std::string text;
  bool old = false;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin != std::string::npos && line[begin] == '[' && line.find('=') == std::string::npos)
      old = std::ranges::any_of(std::array{"[calibration]", "[hold]", "[slide]"},
                                [&](const char* table) { return line.compare(begin, std::strlen(table), table) == 0; });
    if (!old) text += line + "\n";
  }
  for (const std::string& remark : remarks) text += "# " + one_line(remark) + "\n";
  return text + calibration_text(calibration);
}

}  // namespace tactel::host
