// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/commands/command.h"
#include "host/scenes/sweep_file.h"
#include "host/studies/floor/floor.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/training/named_network.h"
#include "host/training/train_request.h"

namespace tactel::host {
namespace {

constexpr int most_frames = 64;

struct FloorRequest {
  std::string sweep, json, device;
  std::vector<std::string> networks;
  std::vector<double> noises, gains, thicknesses;
  std::vector<int> tactels;
  std::vector<std::string> histories;
  std::optional<double> history_change;
  std::string noise_of = "frame";
  FloorOptions options;
  bool quiet = false;
};

/// A skin to measure.
struct Skin {
  std::optional<int> tactels;
  std::optional<double> thickness;  ///< mm
  FloorOptions options;
};

template <class T>
std::vector<std::optional<T>> or_that_of_the_file(const std::vector<T>& values) {
  return values.empty() ? std::vector<std::optional<T>>(1)
                        : std::vector<std::optional<T>>(values.begin(), values.end());
}

/// All combinations.
std::vector<Skin> skins_of(const FloorRequest& request) {
  const auto given = [](const auto& values, auto otherwise) {
    return values.empty() ? std::vector{otherwise} : values;
  };
  std::vector<nn::InputHistory> histories;
  for (const std::string& text : given(request.histories, std::string("1"))) {
    histories.push_back(parse_history(text, {}));
    if (histories.back().frames > most_frames)
      throw ConfigError("command line", "--history", text, fmt::format("at most {} frames", most_frames));
  }
  const bool several = std::ranges::any_of(histories, [](const nn::InputHistory& h) { return h.frames > 1; });
  for (nn::InputHistory& history : histories)
    if (history.frames > 1 || !several)  // one frame alone refuses a change
      history.change = parse_history(fmt::format("{}", history.frames), request.history_change).change;
  std::vector<Skin> skins;
  for (const auto tactels : or_that_of_the_file(request.tactels))
    for (const auto thickness : or_that_of_the_file(request.thicknesses))
      for (const nn::InputHistory& history : histories)
        for (const double noise : given(request.noises, request.options.noise))
          for (const double gain : given(request.gains, request.options.gain)) {
            skins.push_back({tactels, thickness, request.options});
            FloorOptions& options = skins.back().options;
            options.history = history, options.noise = noise, options.gain = gain;
            options.noise_of_contact = request.noise_of == "contact";
          }
  return skins;
}

SceneSource source_of(const FloorRequest& request, const Skin& skin) {
  SceneSource source = read_sweep_of_sensor(request.sweep, skin.tactels, skin.thickness).source;
  if (!source.endless())
    throw ConfigError(request.sweep, "sweep.set", "a listed set",
                      "left out: a floor draws its contacts (sweep.contacts)");
  return source;
}

int run_floor(const FloorRequest& request) {
  const std::vector<Skin> skins = skins_of(request);
  for (const Skin& skin : skins) source_of(request, skin);  // an error before minutes of work
  if (!request.json.empty() && request.json != "-") check_writable("--json", request.json);
  std::vector<nn::Model> models;
  std::vector<std::string> files;
  for (const std::string& path : request.networks)
    for (NamedNetwork& network : read_networks(path)) {
      models.push_back(std::move(network.model));
      files.push_back(network.file);
    }
  Executor executor{Device(request.device)};
  const Interrupt interrupt;
  ProgressLine line("floor", "readings", request.quiet);
  std::vector<SkinFloor> floors;
  for (const Skin& skin : skins) {
    const SceneSource source = source_of(request, skin);
    FloorOptions options = skin.options;
    options.progress = [&](std::size_t done, std::size_t all) {
      line.show(floors.size() * all + done, skins.size() * all);
      return !interrupt.requested();
    };
    auto floor = measure_floor(executor, source, models, options);
    if (!floor) return interrupted;
    const fem::Sensor& sensor = source.sensors().front();
    floors.push_back(
        {sensor.tactels, sensor.span() / (sensor.tactels - 1), sensor.thickness, options, *std::move(floor)});
  }
  line.clear();
  const bool one = floors.size() == 1;
  nlohmann::ordered_json json = {{"tactel", TACTEL_VERSION}, {"sweep", request.sweep}};
  if (one)
    json.update(to_json(floors[0].floor, floors[0].options, files));
  else
    json["skins"] = to_json(floors, files);
  if (request.json == "-") {
    fmt::print("{}", json_text(json));
    return done;
  }
  if (!request.json.empty()) write_file("--json", request.json, json_text(json));
  fmt::print("{}", one ? floor_table(floors[0].floor, floors[0].options, files) : skin_table(floors, files));
  return done;
}

}  // namespace

void add_floor_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<FloorRequest>();
  FloorOptions& options = request->options;
  CLI::App* command = app.add_subcommand(
      "floor", "how well S can be read at all from the frames of a sweep: numbers below and above the smallest error");
  command->group("Verify");
  command->add_option("sweep", request->sweep, "sweep file (TOML)")->type_name("SWEEP.toml")->required();
  command
      ->add_option("--noise", request->noises,
                   "standard deviation of a reading's noise, over the largest |stress| of --noise-of; "
                   "repeatable (default: 0.01)")
      ->check(CLI::Range(1e-6, 10.0))
      ->allow_extra_args(false);
  command->add_option("--noise-of", request->noise_of, "frame: the newest frame; contact: all frames of the contact")
      ->check(CLI::IsMember({"frame", "contact"}))
      ->capture_default_str();
  command
      ->add_option("--gain", request->gains,
                   "standard deviation of the transducers' gains about 1; they do not change along a contact; "
                   "repeatable (default: 0)")
      ->check(CLI::Range(0.0, 10.0))
      ->allow_extra_args(false);
  command
      ->add_option("--history", request->histories,
                   "k or k:stride frames of a reading, kept as those of a network's input; repeatable (default: 1)")
      ->allow_extra_args(false);
  command
      ->add_option("--history-change", request->history_change,
                   "with --history: change of load from one kept frame to the next, over the contact's largest stress "
                   "(default: 0.1)")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--tactels", request->tactels, "number of tactels, instead of the file's; repeatable")
      ->check(CLI::Range(2, 4096))
      ->allow_extra_args(false);
  command->add_option("--thickness", request->thicknesses, "mm of rubber, instead of the file's; repeatable")
      ->check(CLI::PositiveNumber)
      ->allow_extra_args(false);
  command->add_option("--network", request->networks, "also judge these networks on the readings (repeatable)")
      ->type_name("DIR|FILE.onnx");
  command->add_option("--bank", options.bank, "rows of the bank; more rows narrow the gap")
      ->check(CLI::Range(100, 100'000'000))
      ->capture_default_str();
  command->add_option("--readings", options.readings, "readings that are judged")
      ->check(CLI::Range(10, 10'000'000))
      ->capture_default_str();
  command->add_option("--seed", options.seed, "of noise and gains")->capture_default_str();
  command->add_option("--json", request->json, "write all numbers as JSON; - for standard output, instead of the table")
      ->type_name("FILE");
  command->add_option("--device", request->device, "OpenCL device: a part of its name or its index")
      ->type_name("NAME|INDEX");
  command->add_flag("--quiet", request->quiet, "print only errors and the result");
  command->callback([request, &action] { action = [request] { return run_floor(*request); }; });
}

}  // namespace tactel::host
