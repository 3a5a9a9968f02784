#include "host/ladder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors.h"
#include "host/gap_sweep.h"
#include "host/nearest_word.h"

namespace tactel::host {
namespace {

/// Intervals that are to a sensor's length what `intervals` are to the default sensor's, by its thickness.
int scaled(int intervals, const fem::Sensor& sensor) {
  const fem::Sensor usual;
  const double ratio = sensor.length / sensor.thickness * usual.thickness / usual.length;
  return std::max(2, static_cast<int>(std::lround(intervals * ratio)));
}

}  // namespace

const std::vector<Rung>& ladder() {
  using enum Precision;
  static const std::vector<Rung> rungs = {
      {.name = "draft", .columns = 41, .rows = 11, .steps = 1, .precision = fp32, .tolerance = 1e-2},
      {.name = "paper", .columns = 41, .rows = 11, .steps = 1, .precision = fp32, .tolerance = 1e-4},
      {.name = "medium", .columns = 81, .rows = 17, .steps = 2, .precision = fp32, .tolerance = 1e-3},
      {.name = "fine", .columns = 161, .rows = 25, .steps = 4, .precision = fp32, .tolerance = 1e-4},
      {.name = "finest", .columns = 321, .rows = 25, .steps = 10, .precision = fp32, .tolerance = 1e-5},
      {.name = "reference", .columns = 641, .rows = 25, .steps = 20, .precision = fp64, .tolerance = 1e-7}};
  return rungs;
}

std::vector<std::string> rung_names() {
  std::vector<std::string> names;
  for (const Rung& rung : ladder()) names.push_back(rung.name);
  return names;
}

const Rung& rung_named(const std::string& name) {
  const auto found = std::ranges::find(ladder(), name, &Rung::name);
  if (found == ladder().end()) throw ConfigError("command line", "--rung", name, listed(rung_names()));
  return *found;
}

std::string description(const Rung& rung) {
  const std::string mesh = rung.spread == 1 ? "" : fmt::format("{} on ", rung.columns);
  return fmt::format("{}{} x {} {}, {} step{}, {} {:.0e}", mesh, (rung.columns - 1) * rung.spread + 1, rung.rows,
                     fem::name(rung.element), rung.steps, rung.steps == 1 ? "" : "s", name(rung.precision),
                     rung.tolerance);
}

fem::Scene on_rung(const fem::Scene& scene, const Rung& rung) {
  fem::Scene result = scene;
  result.sensor.columns = scaled(rung.columns - 1, scene.sensor) * rung.spread + 1;
  result.sensor.rows = rung.rows;
  result.sensor.element = rung.element;
  result.load.indentation_steps = rung.steps;
  return result;
}

std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes) {
  std::vector<fem::Scene> modelled;
  for (const fem::Scene& scene : scenes) modelled.push_back(on_rung(scene, rung));
  GapSweepOptions options;
  options.tolerance = rung.tolerance;
  options.spread = rung.spread;
  options.nodes = nodes;
  options.fallback = rung.spread == 1;  // which solves the block's own gap elements
  return solve_gap_sweep(executor, modelled, rung.precision, options);
}

std::vector<std::size_t> asked_steps(const fem::Load& load, std::size_t steps_made) {
  const std::size_t targets = load.normal_force.empty() ? load.indentation.size() : load.normal_force.size();
  const std::size_t pressed = targets * load.indentation_steps;
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < steps_made; ++k)
    if (k >= pressed || (k + 1) % load.indentation_steps == 0) places.push_back(k);
  return places;
}

}  // namespace tactel::host
