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

namespace tactel::host {
namespace {

constexpr double poisson_reach = 0.04, most_poisson = 0.4995;

/// Means of the frames around the times, [times, channels] in the device's units.
Eigen::MatrixXd mean_readings(const std::filesystem::path& path, const SensorProfile& profile,
                              const std::vector<double>& times, double window, TomlTable& in) {
  hw::Decoder decoder(profile.format());
  const auto channels = static_cast<Eigen::Index>(decoder.format().channels());
  const auto count = static_cast<Eigen::Index>(times.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, channels), n = sum;
  hw::ReplaySource source(path);
  std::optional<double> first;
  read_frames(source, decoder, {.frame = [&](const hw::DecodedFrame& frame, double arrival) {
                if (!first) first = arrival;
                for (Eigen::Index k = 0; k < count; ++k) {
                  if (std::abs(arrival - *first - times[static_cast<std::size_t>(k)]) > window / 2) continue;
                  for (Eigen::Index c = 0; c < channels; ++c) {
                    const double value = frame.values[static_cast<std::size_t>(c)];
                    if (std::isfinite(value)) sum(k, c) += value, n(k, c) += 1;
                  }
                }
              }});
  for (Eigen::Index k = 0; k < count; ++k)
    if (n.row(k).maxCoeff() == 0)
      in.refuse("times", fmt::format("times within the recording {}: {:g} s has no frame", path.string(),
                                     times[static_cast<std::size_t>(k)]));
  return sum.array() / n.array();  // a channel without a number: NaN
}

KnownPress read_press(const TomlFile& file, const std::string& name, const SensorProfile& profile) {
  TomlTable in(file, name);
  std::string scene, recording;
  std::vector<double> times, P;
  double window = 0.1;
  in.read("scene", scene, "a scene file");
  in.read("recording", recording, "a file of tactel record");
  in.read("times", times, "an array of s since the first frame, one for each load step");
  in.read("P", P, "an array of N/mm, one for each load step");
  in.read("window", window, "s above 0, over which frames are averaged");
  in.finish();
  if (scene.empty()) in.refuse_missing("scene", "a scene file");
  if (recording.empty()) in.refuse_missing("recording", "a file of tactel record");
  if (times.empty()) in.refuse_missing("times", "an array of s since the first frame, one for each load step");
  if (!(window > 0 && std::isfinite(window))) in.refuse("window", "s above 0, over which frames are averaged");
  const std::filesystem::path folder = file.path().parent_path();
  KnownPress press{.name = name, .scene = read_scene(folder / scene), .readings = {}, .P = {}};
  const fem::LoadPath path = fem::load_path(press.scene.load);
  if (path.until_sliding || path.steps.size() != times.size())
    in.refuse("times", fmt::format("as long as the scene has load steps, {}", path.steps.size()));
  if (!P.empty() && P.size() != times.size()) in.refuse("P", fmt::format("as long as times, {}", times.size()));
  const auto tactels = static_cast<std::size_t>(press.scene.sensor.tactels);
  if (tactels != profile.map.tactels())
    in.refuse("scene", fmt::format("a scene with the profile's {} tactels", profile.map.tactels()));
  const Eigen::MatrixXd readings = mean_readings(folder / recording, profile, times, window, in);
  press.readings.setConstant(readings.rows(), static_cast<Eigen::Index>(2 * tactels),
                             std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < 2 * tactels; ++i) {
    const int channel = i < tactels ? profile.map.normal[i] : profile.map.shear[i - tactels];
    if (channel >= 0) press.readings.col(static_cast<Eigen::Index>(i)) = readings.col(channel);
  }
  press.P = Eigen::Map<const Eigen::VectorXd>(P.data(), static_cast<Eigen::Index>(P.size()));
  return press;
}

bool same_sensor(const fem::Sensor& a, const fem::Sensor& b) {
  return a.length == b.length && a.thickness == b.thickness && a.poisson == b.poisson && a.young == b.young &&
         a.tactels == b.tactels && a.span() == b.span() && a.tactel_width == b.tactel_width;
}

}  // namespace

PressRecordings read_press_recordings(const std::filesystem::path& path, const SensorProfile& profile) {
  const TomlFile file(path);
  PressRecordings result;
  TomlTable root(file, "");
  for (const std::string& name : root.keys()) {
    root.expect_table(name);
    if (name != "fit") result.presses.push_back(read_press(file, name, profile));
  }
  root.finish();
  TomlTable fit(file, "fit");
  if (result.presses.empty()) fit.refuse("press", "at least one table of a press: scene, recording, times");
  const fem::Sensor& sensor = result.presses.front().scene.sensor;
  for (const KnownPress& press : result.presses)
    if (!same_sensor(sensor, press.scene.sensor))
      throw ConfigError(path.string(), press.name + ".scene", "another sensor",
                        "a scene with the sensor of " + result.presses.front().name);
  CalibrationOptions& options = result.options;
  fit.read("poisson", options.fit_poisson, "true or false");
  fit.read("thickness", options.fit_thickness, "true or false");
  fit.read("shift", options.fit_shift, "true or false");
  fit.read("force_noise", options.force_noise, "standard deviation of P over P, above 0");
  fit.read("lowest_reading", options.lowest_reading, "the lowest reading of the converter");
  fit.read("highest_reading", options.highest_reading, "the highest reading of the converter");
  fit.finish();
  result.poisson_low = result.poisson_high = sensor.poisson;
  if (options.fit_poisson) {
    result.poisson_low = std::max(0.0, sensor.poisson - poisson_reach);
    result.poisson_high = std::min(sensor.poisson + poisson_reach, most_poisson);
  }
  try {
    options.validate();
  } catch (const ValueError& error) {
    throw file.error(ValueError("fit." + error.key, error.value, error.allowed));
  }
  return result;
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
  for (const std::string& remark : remarks) text += "# " + remark + "\n";
  return text + calibration_text(calibration);
}

}  // namespace tactel::host
