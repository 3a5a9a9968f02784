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

int most_intervals(const Rung& rung) { return (fem::most_columns - 1) / rung.spread; }

int intervals(const Rung& rung, const fem::Sensor& sensor) {
  return static_cast<int>(std::min<double>(wanted_intervals(rung, sensor), most_intervals(rung)));
}

std::string described(const Rung& rung, int intervals) {
  const std::string mesh = rung.spread == 1 ? "" : fmt::format("{} on ", intervals + 1);
  return fmt::format("{}{} x {} {}, {} step{}, {} {:.0e}", mesh, intervals * rung.spread + 1, rung.rows,
                     fem::name(rung.element), rung.steps, rung.steps == 1 ? "" : "s", name(rung.precision),
                     rung.tolerance);
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

std::string description(const Rung& rung) { return described(rung, rung.columns - 1); }

std::string description(const Rung& rung, const fem::Sensor& sensor) {
  return described(rung, intervals(rung, sensor));
}

int columns_of(const Rung& rung, const fem::Sensor& sensor) { return intervals(rung, sensor) + 1; }

bool carries(const fem::Sensor& sensor, const Rung& rung) {
  return wanted_intervals(rung, sensor) <= most_intervals(rung);
}

fem::Scene on_rung(const fem::Scene& scene, const Rung& rung) {
  fem::Scene result = scene;
  result.sensor.columns = intervals(rung, scene.sensor) * rung.spread + 1;
  result.sensor.rows = rung.rows;
  result.sensor.element = rung.element;
  result.load.indentation_steps = rung.steps;
  return result;
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
