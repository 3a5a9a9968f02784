// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/calibration/calibration_page.h"
#include "host/calibration/median.h"
#include "host/calibration/press_recordings.h"
#include "host/commands/command.h"
#include "host/support/durable_file.h"
#include "host/support/host_threads.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

/// Deviation of an offset over the noise at rest, from which it may pass for a shift of one (live/drift_watch.h).
constexpr double unsure_offset = 0.5;

struct CalibrateSensorRequest {
  std::string recordings, profile, output, json, html, plot;
  bool quiet = false;
};

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }
Json number(const Fitted& fitted) { return {{"value", number(fitted.value)}, {"deviation", number(fitted.deviation)}}; }
Json numbers(const auto& values) {
  Json all = Json::array();
  for (const auto& value : values) all.push_back(number(value));
  return all;
}

Json to_json(const SensorCalibration& found, const std::vector<KnownPress>& presses,
             const Eigen::VectorXd& noise_at_rest) {
  Json faults = Json::array(), residuals = faults, correlation = faults;
  for (const CalibrationFault& fault : found.faults)
    faults.push_back({{"kind", fault_names[static_cast<int>(fault.kind)]}, {"text", fault.text}});
  for (Eigen::Index i = 0; i < found.correlation.rows(); ++i)
    correlation.push_back(std::vector<double>(found.correlation.row(i).begin(), found.correlation.row(i).end()));
  for (std::size_t i = 0; i < presses.size(); ++i) {
    Json rows = Json::array();
    for (const auto& row : found.residuals[i].rowwise()) rows.push_back(numbers(row));
    residuals.push_back({{"press", presses[i].name}, {"steps", std::move(rows)}});
  }
  Json json = {{"converged", found.converged}, {"iterations", found.iterations}};
  for (int k = 0; k < sensor_numbers; ++k)
    if (k != shift_y_number) json[sensor_table[k].key] = number(found.*found_numbers[k]);
  json.update({{"friction", numbers(found.friction)},
               {"fitted", found.fitted},
               {"correlation", std::move(correlation)},
               {"held", found.held},
               {"faults", std::move(faults)},
               {"gain", numbers(found.gain)},
               {"offset", numbers(found.offset)},
               {"noise", numbers(found.noise)},
               {"rest_noise", numbers(noise_at_rest)},
               {"residuals", std::move(residuals)}});
  if (found.pad) json["shift_y"] = number(found.shift_y);
  return json;
}

std::string line(const std::string& name, const Fitted& fitted, const std::string& unit) {
  const std::string end = (unit.empty() ? "" : " ") + unit;
  if (fitted.deviation == 0) return fmt::format("{} = {:.5g}{} (held)", name, fitted.value, end);
  return fmt::format("{} = {:.5g} +- {:.2g}{}", name, fitted.value, fitted.deviation, end);
}

/// The noise at rest, as sweeps take it, and whether offsets are known well enough beside it.
std::vector<std::string> noise_remarks(const SensorCalibration& found, const Eigen::VectorXd& noise) {
  std::vector<double> stresses;
  int unsure = 0;
  for (std::size_t i = 0; i < found.gain.size(); ++i) {
    const double of_reading = noise[static_cast<Eigen::Index>(i)];
    if (!std::isfinite(found.gain[i].value) || !std::isfinite(of_reading)) continue;
    stresses.push_back(of_reading * std::abs(found.gain[i].value));
    unsure += found.offset[i].deviation > unsure_offset * of_reading;
  }
  if (stresses.empty()) return {"noise at rest is not known: no window has four frames; tare with this profile"};
  std::vector<std::string> remarks{fmt::format("transducer.noise = {:.2g} MPa (median; {:.2g} to {:.2g})",
                                               median(stresses), std::ranges::min(stresses),
                                               std::ranges::max(stresses))};
  if (unsure > 0)
    remarks.push_back(
        fmt::format("{} of {} offsets are not known within {:g} of the noise at rest: tare with this profile, or drift "
                    "may be reported falsely",
                    unsure, stresses.size(), unsure_offset));
  return remarks;
}

int run_calibrate_sensor(const CalibrateSensorRequest& request) {
  check_writable("--output", request.output);
  for (const auto& [option, path] : {std::pair{"--json", &request.json}, {"--html", &request.html}})
    if (!path->empty()) check_writable(option, *path);
  if (!request.plot.empty()) check_figure_path("--plot", request.plot);
  const SensorProfile profile = read_profile(request.profile);
  const PressRecordings recordings = [&] {
    const StageLine stage("reading " + request.recordings, request.quiet);
    return read_press_recordings(request.recordings, profile);
  }();
  const SensorCalibration found = [&] {
    const StageLine stage("fitting", request.quiet);
    return calibrate_sensor(recordings, host_threads());
  }();
  std::vector<std::string> remarks;
  for (const PressNumber k : numbers_of(found))
    remarks.push_back(line(sensor_table[k].label, found.*found_numbers[k], sensor_table[k].unit));
  for (std::size_t i = 0; i < found.friction.size(); ++i)
    if (found.friction[i].deviation > 0)
      remarks.push_back(line("friction of " + recordings.presses[i].name, found.friction[i], ""));
  for (const std::string& remark : noise_remarks(found, recordings.noise)) remarks.push_back(remark);
  for (const std::string& held : found.held) remarks.push_back(held);
  const bool wrong = std::ranges::any_of(
      found.faults, [](const CalibrationFault& fault) { return fault.kind == CalibrationFault::Kind::wrong_indenter; });
  if (!request.json.empty())
    write_file("--json", request.json, json_text(to_json(found, recordings.presses, recordings.noise)));
  if (!request.html.empty())
    write_file("--html", request.html,
               calibration_page(found, recordings.presses, request.recordings, request.profile).html());
  if (!request.plot.empty()) write_figure("--plot", request.plot, residual_figure(found, recordings.presses));
  if (!request.quiet) {
    for (const std::string& remark : remarks) fmt::print("{}\n", remark);
    for (const CalibrationFault& fault : found.faults) print_warning(fault.text);
  }
  for (const CalibrationFault& fault : found.faults)
    if (fault.kind == CalibrationFault::Kind::model_misfit) remarks.push_back(fault.text);
  if (!found.converged || wrong) {
    print_error(request.output +
                " was not written: " + (wrong ? "the recordings do not fit their scenes" : "the fit did not converge"));
    return not_converged;
  }
  write_file("--output", request.output,
             calibrated_profile(profile, merged_calibration(profile, found, recordings.noise), remarks));
  if (!request.quiet) fmt::print("the calibrated profile is in {}\n", request.output);
  return done;
}

}  // namespace

void add_calibrate_sensor_command(CLI::App& calibrate, Action& action) {
  auto request = std::make_shared<CalibrateSensorRequest>();
  CLI::App* command = calibrate.add_subcommand(
      "sensor", "fit gains, offsets and rubber of a sensor to recordings of known presses and drags");
  command->add_option("recordings", request->recordings, "scenes, recordings, times and forces of the presses (TOML)")
      ->type_name("RECORDINGS.toml")
      ->required();
  command->add_option("--profile", request->profile, "profile of the device")->type_name("P.toml")->required();
  command->add_option("--output", request->output, "profile to write, with the new calibration")
      ->type_name("FILE.toml")
      ->required();
  command->add_option("--json", request->json, "write all numbers, with deviations and residuals")->type_name("FILE");
  command->add_option("--html", request->html, "write a page: gains with deviations, residuals, faults")
      ->type_name("FILE.html");
  command->add_option("--plot", request->plot, "draw the residuals by press and by tactel")
      ->type_name("FILE.svg|png|pdf");
  command->add_flag("--quiet", request->quiet, "no progress, no warnings and no summary");
  command->callback([request, &action] { action = [request] { return run_calibrate_sensor(*request); }; });
}

}  // namespace tactel::host
