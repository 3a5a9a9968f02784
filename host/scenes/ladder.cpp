// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/ladder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/support/errors.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

/// Gap elements less one that are to a sensor's length what the rung's are to the default sensor's, by its thickness.
double wanted_intervals(const Rung& rung, const fem::Sensor& sensor) {
  const fem::Sensor usual;
  const double ratio = sensor.length / sensor.thickness * usual.thickness / usual.length;
  return std::max(2.0, std::round((rung.columns - 1) * ratio));
}

constexpr int most_intervals = fem::most_columns - 1;

int intervals(const Rung& rung, const fem::Sensor& sensor) {
  return static_cast<int>(std::min<double>(wanted_intervals(rung, sensor), most_intervals));
}

std::string solver_text(const Rung& rung) { return fmt::format("{} {:.0e}", name(rung.precision), rung.tolerance); }

std::string mesh_text(const Rung& rung, int intervals) {
  return fmt::format("{} x {} {}, {} step{}, {}", intervals + 1, rung.rows, fem::name(rung.element), rung.steps,
                     rung.steps == 1 ? "" : "s", solver_text(rung));
}

std::string patch_text(const Rung& rung) {
  return fmt::format("{} elements, {} increments, {}", rung.elements, rung.steps, solver_text(rung));
}

/// Other names of rungs.
template <class AnyRung>
std::vector<std::pair<std::string, std::string>> other_names() {
  if (std::is_same_v<AnyRung, PadRung>) return {};
  return {{"draft", "patch-8"}, {"medium", "patch-12"}, {"fine", "patch-16"}, {"finest", "patch-24"}};
}

}  // namespace

template <>
const std::vector<Rung>& all_rungs() {
  using enum Precision;
  const auto rung = [](const char* name, int elements, int columns, int rows, int steps, Precision precision,
                       double tolerance, bool exact = false) {
    Rung made{name, elements, columns, rows, steps, precision, tolerance};
    made.exact = exact;
    return made;
  };
  static const std::vector<Rung> rungs = {rung("patch-8", 8, 81, 17, 3, fp32, 1e-3),
                                          rung("patch-12", 12, 161, 25, 4, fp32, 1e-3),
                                          rung("patch-16", 16, 161, 25, 6, fp32, 1e-3),
                                          rung("patch-24", 24, 161, 25, 8, fp32, 1e-3),
                                          rung("paper", 0, 41, 11, 1, fp32, 1e-4),
                                          rung("mesh-41", 0, 41, 11, 1, fp32, 1e-2),
                                          rung("mesh-81", 0, 81, 17, 2, fp32, 1e-3),
                                          rung("mesh-161", 0, 161, 25, 4, fp32, 1e-4),
                                          rung("mesh-321", 0, 321, 25, 10, fp32, 1e-5),
                                          rung("mesh-641", 0, 641, 25, 20, fp64, 1e-7),
                                          rung("patch-60", 60, 321, 25, 10, fp64, 1e-9, true),
                                          rung("reference", 120, 641, 25, 20, fp64, 1e-9, true)};
  return rungs;
}

template <>
const std::vector<PadRung>& all_rungs() {
  static const std::vector<PadRung> rungs = {
      {"pad-8", 8, 2}, {"pad-12", 12, 4}, {"pad-16", 16, 6}, {"pad-24", 24, 8}, {"reference", 64, 16, true}};
  return rungs;
}

const std::vector<Rung>& ladder() {
  static const std::vector<Rung> rungs = [] {
    std::vector<Rung> climbed;
    for (const char* name : {"patch-8", "patch-12", "patch-16", "patch-24", "patch-60", "reference"})
      climbed.push_back(rung_named(name));
    return climbed;
  }();
  return rungs;
}

template <class AnyRung>
std::vector<std::string> rung_names() {
  std::vector<std::string> names;
  for (const AnyRung& rung : all_rungs<AnyRung>()) names.push_back(rung.name);
  for (const auto& [other, rung] : other_names<AnyRung>()) names.push_back(other);
  return names;
}

template <class AnyRung>
const AnyRung& rung_named(const std::string& name) {
  std::string first_name = name;
  for (const auto& [other, rung] : other_names<AnyRung>())
    if (other == name) first_name = rung;
  const std::vector<AnyRung>& rungs = all_rungs<AnyRung>();
  const auto found = std::ranges::find(rungs, first_name, &AnyRung::name);
  if (found == rungs.end())
    throw ConfigError("command line", "--rung", name,
                      fmt::format("a rung of {}, one of ", std::is_same_v<AnyRung, Rung> ? "lines" : "pads") +
                          listed(rung_names<AnyRung>()) + did_you_mean(name, rung_names<AnyRung>()));
  return *found;
}

template const Rung& rung_named(const std::string&);
template const PadRung& rung_named(const std::string&);
template std::vector<std::string> rung_names<Rung>();
template std::vector<std::string> rung_names<PadRung>();

std::string description(const Rung& rung) {
  return rung.patch() ? patch_text(rung) : mesh_text(rung, rung.columns - 1);
}

std::string description(const PadRung& rung) {
  return fmt::format("{0} x {0} cells, {1} increments", rung.cells, rung.increments);
}

std::string description(const Rung& rung, const fem::Sensor& sensor) {
  return rung.patch() ? patch_text(rung) : mesh_text(rung, intervals(rung, sensor));
}

bool carries(const fem::Sensor& sensor, const Rung& rung) {
  return rung.patch() || wanted_intervals(rung, sensor) <= most_intervals;
}

fem::Scene on_mesh(const fem::Scene& scene, const Rung& rung) {
  fem::Scene result = scene;
  result.sensor.columns = intervals(rung, scene.sensor) + 1;
  result.sensor.rows = rung.rows;
  result.sensor.element = rung.element;
  result.load.indentation_steps = rung.steps;
  return result;
}

fem::Scene on_rung(const fem::Scene& scene, const Rung& rung) { return rung.patch() ? scene : on_mesh(scene, rung); }

std::vector<std::size_t> asked_steps(const fem::Load& load, std::size_t steps_made) {
  const std::size_t targets = load.normal_force.empty() ? load.indentation.size() : load.normal_force.size();
  const std::size_t pressed = targets * load.indentation_steps;
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < steps_made; ++k)
    if (k >= pressed || (k + 1) % load.indentation_steps == 0) places.push_back(k);
  return places;
}

}  // namespace tactel::host
