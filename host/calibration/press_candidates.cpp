// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/press_candidates.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "fem/value_error.h"
#include "host/calibration/press_recordings.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/scene_json.h"

namespace tactel::host {
namespace {

constexpr double rest = 1, motion = 0.3, hold = 0.7;  ///< s of a planned press: at rest, then for each load step
constexpr double beside = 1;                          ///< mm of rubber beside the lowest part of an indenter
constexpr std::size_t most_candidates = 5000;

double rounded(double value, double step) { return std::round(value / step) * step + 0.0; }

/// A third, two thirds, and all of a drag.
std::vector<double> drag_steps(double drag) {
  if (drag == 0) return {};
  return {rounded(drag / 3, 0.001), rounded(drag * 2 / 3, 0.001), drag};
}

/// Shape and its numbers: "cylinder, radius 6".
std::string shape_text(const fem::Scene& scene) {
  const nlohmann::ordered_json indenter = to_json(scene).at("indenter");
  std::string text;
  for (const auto& [key, value] : indenter.items())
    if (key == "shape")
      text = value.get<std::string>();
    else if (key != "position" && value.is_number())
      text += fmt::format(", {} {:g}", key, value.get<double>());
  return text;
}

/// What a table of a list varies; empty: as the scene has it.
struct Variation {
  std::vector<double> position{}, indentation{}, normal_force{}, drag{};
};

std::vector<fem::Scene> varied(const fem::Scene& scene, const Variation& by) {
  std::vector<fem::Scene> all{scene};
  const auto vary = [&all](const std::vector<double>& values, const auto& set) {
    if (values.empty()) return;
    std::vector<fem::Scene> next;
    for (const fem::Scene& press : all)
      for (const double value : values) set(next.emplace_back(press), value);
    all = std::move(next);
  };
  vary(by.position, [](fem::Scene& press, double value) { press.indenter.position = value; });
  vary(by.indentation, [](fem::Scene& press, double value) {
    press.load.indentation = {value};
    press.load.normal_force.clear();
  });
  vary(by.normal_force, [](fem::Scene& press, double value) {
    press.load.normal_force = {value};
    press.load.indentation.clear();
  });
  vary(by.drag, [](fem::Scene& press, double value) {
    press.load.tangential_step = 0;
    press.load.tangential_steps.reset();
    press.load.moves.clear();
    press.load.angle.reset();
    press.load.tangential = drag_steps(value);
  });
  return all;
}

PressCandidate candidate(std::string indenter, const fem::Scene& scene) {
  return {std::move(indenter), scene, planned_timing(fem::load_path(scene.load).steps.size())};
}

/// The scene of a table of a list, and what it varies.
std::vector<fem::Scene> read_candidate_table(const TomlFile& file, const std::string& name, std::size_t tactels) {
  TomlTable in(file, name);
  std::string scene_name;
  Variation by;
  in.read("scene", scene_name, "a scene file");
  in.read_one_or_more("position", by.position, "mm along the array, or an array of them");
  in.read_one_or_more("indentation", by.indentation, "a depth in mm, or an array of them");
  in.read_one_or_more("normal_force", by.normal_force, "a force in N/mm, or an array of them");
  in.read_one_or_more("drag", by.drag, "mm from first touch to the end of the drag, or an array of them; 0: no drag");
  in.finish();
  if (scene_name.empty()) in.refuse_missing("scene", "a scene file: indenter, friction, load and nominal sensor");
  if (!by.indentation.empty() && !by.normal_force.empty())
    in.refuse("normal_force", "left out, because indentation is given too");
  const fem::Scene scene = read_scene(file.path().parent_path() / scene_name);
  if (static_cast<std::size_t>(scene.sensor.tactels) != tactels)
    in.refuse("scene", fmt::format("a scene with the profile's {} tactels", tactels));
  std::vector<fem::Scene> all = varied(scene, by);
  for (const fem::Scene& press : all) {
    if (fem::load_path(press.load).until_sliding)
      in.refuse("scene", "a drag with a number of steps: load.tangential, or drag in this table");
    try {
      press.validate();
    } catch (const ValueError& error) {
      throw file.error(ValueError(name + ": " + error.key, error.value, error.allowed));
    }
  }
  return all;
}

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

std::string scene_text(const fem::Scene& scene) {
  nlohmann::ordered_json json = to_json(scene);
  nlohmann::ordered_json& sensor = json["sensor"];
  for (const char* mesh : {"columns", "rows", "grading", "element", "stress"}) sensor.erase(mesh);
  sensor["model"] = "patch";
  if (json["indenter"].contains("x")) json["indenter"].erase("file");
  std::string text;
  for (const char* table : {"sensor", "indenter", "contact", "load"}) {
    text += fmt::format("[{}]\n", table);
    for (const auto& [key, value] : json[table].items()) text += fmt::format("{} = {}\n", key, value.dump());
  }
  return text;
}

}  // namespace

PressTiming planned_timing(std::size_t steps) {
  PressTiming timing;
  for (std::size_t k = 0; k < steps; ++k) {
    const double begin = rest + (motion + hold) * static_cast<double>(k);
    timing.begin.push_back(begin);
    timing.end.push_back(begin + motion);
    timing.time.push_back(begin + motion + hold - planned_window / 2 - 0.1);
  }
  return timing;
}

std::vector<PressCandidate> usual_candidates(const fem::Scene& nominal) {
  struct Tool {
    fem::Shape shape;
    double half_width;  ///< mm of its lowest part
  };
  const Tool tools[] = {
      {fem::Cylinder{3}, 0}, {fem::Cylinder{6}, 0}, {fem::Cylinder{15}, 0}, {fem::Flat{2.0}, 2}, {fem::Wedge{150}, 0}};
  const fem::Sensor& sensor = nominal.sensor;
  const double deep = rounded(sensor.thickness * 2 / 15, 0.01), far = rounded(sensor.thickness * 0.08 / 1.5, 0.001);
  std::vector<PressCandidate> all;
  for (const Tool& tool : tools) {
    fem::Scene scene = nominal;
    scene.model = fem::SurfaceModel::patch;
    scene.indenter = {tool.shape, 0};
    scene.load = {};
    scene.load.indentation_steps = 2;
    const double reach = std::min(sensor.span() / 2, sensor.length / 2 - beside - tool.half_width);
    Variation by{.indentation = {deep / 2, deep}, .drag = {0, far, -far}};
    for (int k = -5; k <= 5; ++k) by.position.push_back(rounded(reach * k / 5, 0.1));
    for (const fem::Scene& press : varied(scene, by)) all.push_back(candidate(shape_text(press), press));
  }
  return all;
}

CandidateList read_candidates(const std::filesystem::path& path, std::size_t tactels) {
  const TomlFile file(path);
  CandidateList list{.candidates = {}, .fit = read_fit(file), .fit_text = {}};
  TomlTable root(file, "");
  for (const std::string& name : root.keys()) {
    root.expect_table(name);
    if (name == "fit" || name == "transducer") continue;
    for (const fem::Scene& scene : read_candidate_table(file, name, tactels))
      list.candidates.push_back(candidate(name, scene));
    const PressCandidate& first = list.candidates.front();
    require_same_sensor(file, name, list.candidates.back().scene, first.indenter, first.scene);
    if (list.candidates.size() > most_candidates)
      throw file.error(name, nullptr, fmt::format("at most {} candidates in all", most_candidates));
  }
  root.finish();
  if (list.candidates.empty())
    throw file.error("press", nullptr, "at least one table of candidates: scene, position, indentation, drag");
  const CalibrationOptions& fit = list.fit;
  list.fit_text = fmt::format(
      "[fit]\npoisson = {}\nthickness = {}\nshift = {}\ntime_constant = {}\nfriction = {:g}\nforce_noise = {:g}\n",
      fit.fit_poisson, fit.fit_thickness, fit.fit_shift, fit.fit_time_constant, fit.friction_deviation,
      fit.force_noise);
  if (std::isfinite(fit.lowest_reading)) list.fit_text += fmt::format("lowest_reading = {}\n", fit.lowest_reading);
  if (std::isfinite(fit.highest_reading)) list.fit_text += fmt::format("highest_reading = {}\n", fit.highest_reading);
  if (std::isfinite(fit.time_constant))
    list.fit_text += fmt::format("\n[transducer]\ntime_constant = {}\n", fit.time_constant);
  return list;
}

std::vector<PlanFile> plan_files(const std::filesystem::path& path, const std::vector<PressCandidate>& chosen,
                                 const std::string& fit_text, bool forces) {
  const std::string stem = path.stem().string();
  std::string text =
      "# Planned presses. Record each with tactel record, from before the first touch; then\n"
      "# tactel calibrate sensor reads this file. A press is a second at rest, then a second for each load step\n"
      "# of its scene: move at begin, rest from end on. Correct times, begin and end to what was done.\n" +
      fit_text;
  std::vector<PlanFile> files{{path, {}}};
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const PressCandidate& press = chosen[i];
    const std::string name = fmt::format("{}-{:02}", stem, i + 1);
    files.push_back(
        {path.parent_path() / (name + ".toml"), "# " + one_line(press.indenter) + "\n" + scene_text(press.scene)});
    text += fmt::format(
        "\n[press-{:02}]  # {} at {:g} mm\nscene = {}\nrecording = {}\ntimes = [{:g}]\nbegin = [{:g}]\nend = "
        "[{:g}]\nwindow = {:g}\n",
        i + 1, one_line(press.indenter), press.scene.indenter.position, quoted(name + ".toml"),
        quoted(name + ".tactel"), fmt::join(press.timing.time, ", "), fmt::join(press.timing.begin, ", "),
        fmt::join(press.timing.end, ", "), planned_window);
    if (forces)
      text += fmt::format("# P = [ ]  # N/mm: force over length of the indenter, measured at these {} times\n",
                          press.timing.time.size());
  }
  files.front().text = text;
  return files;
}

}  // namespace tactel::host
