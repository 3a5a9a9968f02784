// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/press_recordings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/live/frame_reader.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/toml_table.h"
#include "hw/recording.h"
#include "hw/tare.h"

namespace tactel::host {
namespace {

constexpr double poisson_reach = 0.04, most_poisson = 0.4995;
constexpr std::size_t fewest_frames = 4;  ///< of a window, for its noise

/// Frames around the times of a press, in the device's units.
struct WindowReadings {
  Eigen::MatrixXd mean;   ///< [times, channels]; NaN: a channel without a number
  Eigen::MatrixXd noise;  ///< [times, channels] of these means; NaN: too few frames
};

WindowReadings read_windows(const std::filesystem::path& path, const SensorProfile& profile,
                            const std::vector<double>& times, double window, TomlTable& in) {
  hw::Decoder decoder(profile.format());
  const std::size_t channels = decoder.format().channels();
  std::vector<hw::Tare> windows(times.size(), hw::Tare(channels));
  hw::ReplaySource source(path);
  std::optional<double> first;
  read_frames(source, decoder, {.frame = [&](const hw::DecodedFrame& frame, double arrival) {
                if (!first) first = arrival;
                for (std::size_t k = 0; k < times.size(); ++k)
                  if (std::abs(arrival - *first - times[k]) <= window / 2) windows[k].add(frame.values);
              }});
  WindowReadings result;
  result.mean.setConstant(static_cast<Eigen::Index>(times.size()), static_cast<Eigen::Index>(channels),
                          std::numeric_limits<double>::quiet_NaN());
  result.noise = result.mean;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (windows[k].frames() == 0)
      in.refuse("times", fmt::format("times within the recording {}: {:g} s has no frame", path.string(), times[k]));
    for (std::size_t c = 0; c < channels; ++c) {
      const hw::ChannelRest rest = windows[k].channel(c);
      const auto row = static_cast<Eigen::Index>(k), column = static_cast<Eigen::Index>(c);
      if (rest.readings > 0) result.mean(row, column) = rest.mean;
      if (rest.readings >= fewest_frames)  // noise below half a step is not averaged out
        result.noise(row, column) =
            rest.noise > rest.step / 2 ? rest.noise / std::sqrt(static_cast<double>(rest.readings)) : rest.step / 2;
    }
  }
  return result;
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

/// Reads a press; adds the noise of its readings [2 tactels] while the indenter rests, a row for each load step.
KnownPress read_press(const TomlFile& file, const std::string& name, const SensorProfile& profile, bool decays,
                      std::vector<Eigen::RowVectorXd>& noise) {
  TomlTable in(file, name);
  std::string scene, recording;
  std::vector<double> times, P;
  double window = 0.1;
  in.read("scene", scene, "a scene file");
  in.read("recording", recording, "a file of tactel record");
  in.read("times", times, "an array of s since the first frame, one for each load step");
  in.read("P", P, "an array of N/mm, one for each load step");
  in.read("window", window, "s above 0, over which frames are averaged");
  PressTiming timing = read_timing(in, times, window);
  in.finish();
  if (scene.empty()) in.refuse_missing("scene", "a scene file");
  if (recording.empty()) in.refuse_missing("recording", "a file of tactel record");
  if (times.empty()) in.refuse_missing("times", "an array of s since the first frame, one for each load step");
  if (!(window > 0 && std::isfinite(window))) in.refuse("window", "s above 0, over which frames are averaged");
  const std::filesystem::path folder = file.path().parent_path();
  KnownPress press{
      .name = name, .scene = read_scene(folder / scene), .readings = {}, .P = {}, .timing = std::move(timing)};
  const fem::LoadPath path = fem::load_path(press.scene.load);
  if (path.until_sliding || path.steps.size() != times.size())
    in.refuse("times", fmt::format("as long as the scene has load steps, {}", path.steps.size()));
  if (!P.empty() && P.size() != times.size()) in.refuse("P", fmt::format("as long as times, {}", times.size()));
  try {
    if (decays) press.timing.validate(times.size());
  } catch (const ValueError& error) {
    throw file.error(ValueError(name + "." + error.key, error.value, error.allowed));
  }
  const auto tactels = static_cast<std::size_t>(press.scene.sensor.tactels);
  if (tactels != profile.map.tactels())
    in.refuse("scene", fmt::format("a scene with the profile's {} tactels", profile.map.tactels()));
  const WindowReadings readings = read_windows(folder / recording, profile, times, window, in);
  press.readings.setConstant(readings.mean.rows(), static_cast<Eigen::Index>(2 * tactels),
                             std::numeric_limits<double>::quiet_NaN());
  Eigen::MatrixXd own_noise = press.readings;
  for (std::size_t i = 0; i < 2 * tactels; ++i) {
    const int channel = i < tactels ? profile.map.normal[i] : profile.map.shear[i - tactels];
    if (channel < 0) continue;
    press.readings.col(static_cast<Eigen::Index>(i)) = readings.mean.col(channel);
    own_noise.col(static_cast<Eigen::Index>(i)) = readings.noise.col(channel);
  }
  for (Eigen::Index k = 0; k < own_noise.rows(); ++k) noise.emplace_back(own_noise.row(k));
  press.P = Eigen::Map<const Eigen::VectorXd>(P.data(), static_cast<Eigen::Index>(P.size()));
  return press;
}

/// Returns the medians over the rows, 0 where a column has no number; empty where none has.
Eigen::VectorXd median_noise(const std::vector<Eigen::RowVectorXd>& rows) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(rows.front().size());
  bool any = false;
  for (Eigen::Index c = 0; c < result.size(); ++c) {
    std::vector<double> values;
    for (const Eigen::RowVectorXd& row : rows)
      if (std::isfinite(row[c])) values.push_back(row[c]);
    if (values.empty()) continue;
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
    result[c] = values[values.size() / 2];
    any = true;
  }
  return any ? result : Eigen::VectorXd();
}

bool same_sensor(const fem::Sensor& a, const fem::Sensor& b) {
  return a.length == b.length && a.thickness == b.thickness && a.poisson == b.poisson && a.young == b.young &&
         a.tactels == b.tactels && a.span() == b.span() && a.tactel_width == b.tactel_width;
}

}  // namespace

CalibrationOptions read_fit(const TomlFile& file) {
  CalibrationOptions options;
  TomlTable fit(file, "fit"), transducer(file, "transducer");
  fit.read("poisson", options.fit_poisson, "true or false");
  fit.read("thickness", options.fit_thickness, "true or false");
  fit.read("shift", options.fit_shift, "true or false");
  fit.read("time_constant", options.fit_time_constant, "true or false");
  fit.read("friction", options.friction_deviation, "standard deviation of each press's friction, relative, 0 to 1");
  fit.read("force_noise", options.force_noise, "standard deviation of P over P, above 0");
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

void require_same_sensor(const TomlFile& file, const std::string& name, const fem::Sensor& sensor,
                         const std::string& first, const fem::Sensor& expected) {
  if (!same_sensor(sensor, expected))
    throw ConfigError(file.path().string(), name + ".scene", "another sensor", "a scene with the sensor of " + first);
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
  std::vector<Eigen::RowVectorXd> noise;
  for (const std::string& name : root.keys()) {
    root.expect_table(name);
    if (name != "fit" && name != "transducer")
      result.presses.push_back(read_press(file, name, profile, std::isfinite(result.options.time_constant), noise));
  }
  root.finish();
  if (result.presses.empty())
    throw file.error("press", nullptr, "at least one table of a press: scene, recording, times");
  const KnownPress& first = result.presses.front();
  for (const KnownPress& press : result.presses)
    require_same_sensor(file, press.name, press.scene.sensor, first.name, first.scene.sensor);
  result.options.rest_noise = median_noise(noise);
  return result;
}

std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  return text;
}

hw::Calibration merged_calibration(const SensorProfile& profile, const SensorCalibration& found) {
  hw::Calibration calibration = profile.map.calibration;
  const std::size_t tactels = profile.map.tactels();
  for (std::size_t i = 0; i < 2 * tactels; ++i) {
    const int channel = i < tactels ? profile.map.normal[i] : profile.map.shear[i - tactels];
    if (channel < 0 || !std::isfinite(found.gain[i].value)) continue;
    calibration.gain[static_cast<std::size_t>(channel)] = found.gain[i].value;
    calibration.offset[static_cast<std::size_t>(channel)] = found.offset[i].value;
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
      old = line.compare(begin, 13, "[calibration]") == 0;
    if (!old) text += line + "\n";
  }
  for (const std::string& remark : remarks) text += "# " + one_line(remark) + "\n";
  return text + calibration_text(calibration);
}

}  // namespace tactel::host
