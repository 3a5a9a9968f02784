// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/calibration/press_candidates.h"
#include "host/calibration/press_recordings.h"
#include "host/commands/command.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/scene_json.h"
#include "host/support/durable_file.h"
#include "host/support/host_threads.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

struct CalibratePlanRequest {
  std::string profile, scene, candidates, output, json;
  int presses = 10;
  double noise = 0;
  bool without_force = false, quiet = false;
};

/// Noise of the readings at rest as a stress, [2 tactels] MPa; empty where the profile does not tell it.
Eigen::VectorXd profile_noise(const hw::ChannelMap& map) {
  const hw::Calibration& calibration = map.calibration;
  if (calibration.noise.empty()) return {};
  const std::size_t tactels = map.tactels();
  Eigen::VectorXd noise(static_cast<Eigen::Index>(2 * tactels));
  for (std::size_t i = 0; i < 2 * tactels; ++i) {
    const int channel = map.channel(i);
    const auto c = static_cast<std::size_t>(std::max(channel, 0));
    const double stress = calibration.noise[c] * std::abs(calibration.gain[c]);
    noise[static_cast<Eigen::Index>(i)] =
        channel >= 0 && stress > 0 ? stress : std::numeric_limits<double>::quiet_NaN();
  }
  return noise;
}

/// The candidates of the list, or the usual ones on the scene's sensor.
CandidateList candidates_of(const CalibratePlanRequest& request, const SensorProfile& profile) {
  if (!request.candidates.empty()) return read_candidates(request.candidates, profile.map.tactels());
  fem::Scene nominal;
  nominal.sensor.tactels = static_cast<int>(profile.map.tactels());
  if (!request.scene.empty()) nominal = read_scene(request.scene);
  if (static_cast<std::size_t>(nominal.sensor.tactels) != profile.map.tactels())
    throw ConfigError("command line", "--scene", request.scene,
                      fmt::format("a scene with the profile's {} tactels", profile.map.tactels()));
  return {usual_candidates(nominal), {}, {}};
}

struct DeviationRow {
  const char *name, *key;
  double value;
  std::string unit = "%";  ///< of 100 times the value
};

std::vector<DeviationRow> rows_of(const ExpectedDeviations& deviations) {
  std::vector<DeviationRow> rows = {{"gain of normal stress, median", "normal_gain", deviations.normal_gain},
                                    {"gain of shear stress, median", "shear_gain", deviations.shear_gain},
                                    {"gain, worst transducer", "worst_gain", deviations.worst_gain}};
  for (const int k : {young_number, poisson_number, thickness_number, shift_number, time_constant_number}) {
    const SensorNumber& number = sensor_table[k];
    rows.push_back({number.label, number.key, deviations.number[k], number.logarithm ? "%" : number.unit});
  }
  return rows;
}

/// The last position of a drag.
double drag_of(const fem::Scene& scene) { return fem::load_path(scene.load).steps.back().tangential; }

std::string depth_text(const fem::Scene& scene) {
  return fem::by_force(scene) ? fmt::format("{:g} N/mm", scene.load.normal_force.back())
                              : fmt::format("{:g} mm", scene.load.indentation.back());
}

void print_plan(const PressPlan& plan, const std::vector<PressCandidate>& candidates) {
  fmt::print("  #  {:<28} {:>9} {:>10} {:>9} {:>12}\n", "indenter", "place", "press", "drag", "expected P");
  for (std::size_t i = 0; i < plan.chosen.size(); ++i) {
    const PressCandidate& press = candidates[plan.chosen[i]];
    const double drag = drag_of(press.scene);
    fmt::print("{:>3}  {:<28} {:>6.4g} mm {:>10} {:>9} {:>7.3g} N/mm\n", i + 1, press.indenter,
               press.scene.indenter.position, depth_text(press.scene),
               drag == 0 ? "none" : fmt::format("{:.4g} mm", drag), plan.P[plan.chosen[i]]);
  }
  fmt::print("\nstandard deviation to expect\n");
  for (const auto& [name, key, value, unit] : rows_of(plan.planned))
    if (std::isfinite(value))
      fmt::print("{:<32} {:>8.2g}{}{}\n", name, unit == "%" ? 100 * value : value, unit.empty() ? "" : " ", unit);
  if (!plan.lost.empty()) fmt::print("\n");
  for (const std::string& sentence : plan.lost) fmt::print("{}\n", sentence);
}

/// NaN is written as null.
Json deviations_json(const ExpectedDeviations& deviations) {
  Json out, gains = Json::array();
  for (const DeviationRow& row : rows_of(deviations)) out[row.key] = row.value;
  for (const double gain : deviations.gain) gains.push_back(gain);
  out["gain"] = std::move(gains);
  return out;
}

Json plan_json(const PressPlan& plan, const std::vector<PressCandidate>& candidates) {
  Json presses = Json::array(), noise = Json::array();
  for (const std::size_t i : plan.chosen)
    presses.push_back(
        {{"indenter", candidates[i].indenter}, {"P", plan.P[i]}, {"scene", to_json(candidates[i].scene)}});
  for (const double value : plan.noise) noise.push_back(value);
  return {{"candidates", candidates.size()},
          {"presses", std::move(presses)},
          {"noise", std::move(noise)},
          {"planned", deviations_json(plan.planned)},
          {"lost", plan.lost}};
}

int run_calibrate_plan(const CalibratePlanRequest& request) {
  for (const auto& [option, path] : {std::pair{"--output", &request.output}, {"--json", &request.json}})
    if (!path->empty()) check_writable(option, *path);
  const SensorProfile profile = read_profile(request.profile);
  if (!profile.pads.empty())
    throw ConfigError(
        request.profile, "pad", "given",
        "left out: calibrate plan serves lines; press a pad as docs/calibration.md says, and record that");
  const CandidateList list = candidates_of(request, profile);
  PlanOptions options{.presses = request.presses,
                      .fit = list.fit,
                      .forces = !request.without_force,
                      .noise = profile_noise(profile.map),
                      .threads = host_threads()};
  if (request.noise > 0) options.noise_of_largest = request.noise, options.noise.resize(0);
  const PressPlan plan = [&] {
    const StageLine stage(fmt::format("weighing {} presses", list.candidates.size()), request.quiet);
    try {
      return plan_presses(calibration_family(list.candidates.front().scene.sensor, list.fit), list.candidates, options);
    } catch (const ValueError& error) {
      throw ConfigError("command line", error.key == "presses" ? "--presses" : error.key, error.value, error.allowed);
    }
  }();
  if (!request.output.empty()) {
    std::vector<PressCandidate> chosen;
    for (const std::size_t i : plan.chosen) chosen.push_back(list.candidates[i]);
    for (const PlanFile& file : plan_files(request.output, chosen, list.fit_text, options.forces))
      write_file("--output", file.path, file.text);
  }
  if (!request.json.empty()) write_file("--json", request.json, json_text(plan_json(plan, list.candidates)));
  if (request.quiet) return done;
  if (options.noise.size() == 0)
    print_warning(fmt::format("noise is taken as {:g} % of the largest stress: the profile's [calibration] has none",
                              100 * options.noise_of_largest));
  print_plan(plan, list.candidates);
  if (!request.output.empty())
    fmt::print("\n{} and its scenes are written: record each press, and fill in P\n", request.output);
  return done;
}

}  // namespace

void add_calibrate_plan_command(CLI::App& calibrate, Action& action) {
  auto request = std::make_shared<CalibratePlanRequest>();
  CLI::App* command = calibrate.add_subcommand(
      "plan", "choose the presses and drags that tell most of a sensor, before recording them");
  command->add_option("profile", request->profile, "profile of the device")->type_name("PROFILE.toml")->required();
  CLI::Option* scene =
      command->add_option("--scene", request->scene, "scene whose sensor and friction the usual presses take")
          ->type_name("SCENE.toml");
  command
      ->add_option("--candidates", request->candidates,
                   "presses to choose from: scenes, places, depths and drags (default: rods, a flat and a wedge)")
      ->type_name("LIST.toml")
      ->excludes(scene);
  command->add_option("--presses", request->presses, "number of presses to choose")->capture_default_str();
  command
      ->add_option("--noise", request->noise,
                   "standard deviation of a reading over the largest stress (default: the profile's, or 0.01)")
      ->check(CLI::PositiveNumber);
  command->add_flag("--without-force", request->without_force, "P will not be measured");
  command->add_option("--output", request->output, "recordings file to fill in; scenes are written beside it")
      ->type_name("FILE.toml");
  command->add_option("--json", request->json, "write the plan with all deviations")->type_name("FILE");
  command->add_flag("--quiet", request->quiet, "no progress, no warnings and no table");
  command->callback([request, &action] { action = [request] { return run_calibrate_plan(*request); }; });
}

}  // namespace tactel::host
