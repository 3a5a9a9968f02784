// SPDX-License-Identifier: Apache-2.0
#include "fem/scene_derivatives.h"

#include <cmath>
#include <stdexcept>

#include "fem/gap_condensed.h"
#include "fem/shape_derivatives.h"

namespace tactel::fem {
namespace {

constexpr double poisson_step = 1e-3, thickness_step = 1e-3;  ///< of central differences; the second over h
constexpr double consistent = -1e-9;                          ///< distance to a switch: rounding of an exact solution

/// A number of a load.
struct LoadNumber {
  std::string name;
  const char* unit;
  std::function<double&(Load&)> of;
};

std::string indexed(const std::string& name, std::size_t index, std::size_t count) {
  return count == 1 ? name : name + "[" + std::to_string(index) + "]";
}

std::vector<LoadNumber> load_numbers(const Load& load) {
  std::vector<LoadNumber> all;
  const auto add_each = [&](const std::string& name, const char* unit, std::vector<double> Load::*values) {
    for (std::size_t i = 0; i < (load.*values).size(); ++i)
      all.push_back(
          {indexed(name, i, (load.*values).size()), unit, [=](Load& of) -> double& { return (of.*values)[i]; }});
  };
  if (load.normal_force.empty())
    add_each("load.indentation", "mm", &Load::indentation);
  else
    add_each("load.normal_force", "N/mm", &Load::normal_force);
  add_each("load.tangential", "mm", &Load::tangential);
  if (load.tangential_step != 0)
    all.push_back({"load.tangential_step", "mm", [](Load& of) -> double& { return of.tangential_step; }});
  for (std::size_t i = 0; i < load.moves.size(); ++i) {
    const std::string move = "load.moves[" + std::to_string(i) + "]";
    all.push_back({move + ".normal", load.normal_force.empty() ? "mm" : "N/mm",
                   [=](Load& of) -> double& { return of.moves[i].normal; }});
    all.push_back({move + ".tangential", "mm", [=](Load& of) -> double& { return of.moves[i].tangential; }});
  }
  if (load.angle) all.push_back({"load.angle", "degree", [](Load& of) -> double& { return *of.angle; }});
  return all;
}

/// Targets are linear in every number but the angle, and a difference over 1e-3 degrees is off by 1e-10 there.
constexpr double load_step = 1e-3;

}  // namespace

void SceneDerivatives::add(SceneParameter parameter, PathDirection direction) {
  parameters.push_back(std::move(parameter));
  directions.push_back(std::move(direction));
}

void add_common_parameters(const Scene& scene, const Eigen::VectorXd& x,
                           const std::function<std::vector<LoadStep>(const Load&)>& targets, SceneDerivatives& result) {
  for (const HeightDerivative& of : height_derivatives(scene.indenter, x))
    result.add({"indenter." + of.key, of.value, of.unit}, {.height = of.height});
  if (std::holds_alternative<Profile>(scene.indenter.shape))
    result.missing.push_back({"indenter.y", "the points of a measured profile are not parameters"});
  if (std::isfinite(scene.friction))
    result.add({"contact.friction", scene.friction, ""}, {.mu = 1});
  else
    result.missing.push_back({"contact.friction", "the contact is bonded"});
  result.add({"sensor.young", scene.sensor.young, "MPa"}, {.young = 1});
  const auto count = result.path.path().increments.size();
  for (const LoadNumber& number : load_numbers(scene.load)) {
    Load plus = scene.load, minus = scene.load;
    number.of(plus) += load_step;
    number.of(minus) -= load_step;
    const std::vector<LoadStep> to = targets(plus), from = targets(minus);
    if (to.size() != from.size() || to.size() < count) {
      result.missing.push_back({number.name, "it equals its neighbour, so that the path's increments change with it"});
      continue;
    }
    PathDirection direction{.normal = Eigen::VectorXd(count), .tangential = Eigen::VectorXd(count)};
    for (std::size_t k = 0; k < count; ++k) {
      direction.normal[static_cast<Eigen::Index>(k)] = (to[k].normal - from[k].normal) / (2 * load_step);
      direction.tangential[static_cast<Eigen::Index>(k)] = (to[k].tangential - from[k].tangential) / (2 * load_step);
    }
    Load own = scene.load;
    result.add({number.name, number.of(own), number.unit}, std::move(direction));
  }
}

void require_solution(const PathDerivatives& path) {
  for (const PathAnswer& answer : path.answers())
    if (!(answer.distance_to_switch >= consistent))
      throw PathError("the statuses of its elements do not solve the contact");
}

namespace {

/// Statuses of a step as trials, the friction's sign from its force.
std::vector<Trial> trials(const ContactStep& step) {
  std::vector<Trial> result;
  for (std::size_t i = 0; i < step.status.size(); ++i) {
    const bool left = step.tangential_force[static_cast<Eigen::Index>(i)] < 0;
    result.push_back(step.status[i] == GapStatus::open    ? Trial::open
                     : step.status[i] == GapStatus::stick ? Trial::stick
                     : left                               ? Trial::slip_minus
                                                          : Trial::slip_plus);
  }
  return result;
}

/// Central difference of condensations.
PathDirection rubber_direction(const Sensor& plus, const Sensor& minus, double distance,
                               const std::filesystem::path& cache_directory) {
  const Condensation to = condense_cached(plus, cache_directory), from = condense_cached(minus, cache_directory);
  return {.compliance = (to.compliance - from.compliance) / distance,
          .tactel_stress = (to.tactel_stress - from.tactel_stress) / distance};
}

}  // namespace

SceneDerivatives mesh_derivatives(const Scene& scene, int parts, const std::filesystem::path& cache_directory) {
  scene.validate();
  const auto divided = [parts](Load load) {
    load.indentation_steps *= parts;
    return load;
  };
  Scene own_steps = scene;
  own_steps.load = divided(scene.load);
  const Condensation rubber = condense_cached(scene.sensor, cache_directory);
  const ContactSolution solution = GapCondensed(rubber).solve(own_steps);
  const LoadPath load = load_path(own_steps.load);
  ContactPath path{.compliance = rubber.compliance,
                   .tactel_stress = rubber.tactel_stress,
                   .height = profile_heights(scene.indenter, rubber.surface_x),
                   .mu = std::min(scene.friction, largest_friction),
                   .young = scene.sensor.young,
                   .increments = {}};
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    if (!solution.steps[k].converged)
      throw PathError("the active-set method did not solve step " + std::to_string(k + 1));
    const LoadStep from = k > 0 ? load.steps[k - 1] : LoadStep{};
    const bool held = k > 0 && load.steps[k] == from;
    const bool asked = static_cast<int>(k) >= load.indentation_steps || (k + 1) % static_cast<std::size_t>(parts) == 0;
    path.increments.push_back(
        {.target = load.steps[k], .asked = asked, .held = held, .trial = trials(solution.steps[k])});
  }
  const Eigen::VectorXd slopes = profile_slopes(scene.indenter, rubber.surface_x);
  SceneDerivatives result{PathDerivatives(std::move(path)), {}, {}, {}};
  require_solution(result.path);
  add_common_parameters(
      scene, rubber.surface_x, [&](const Load& of) { return load_path(divided(of)).steps; }, result);
  if (std::holds_alternative<Flat>(scene.indenter.shape))
    for (const char* name : {"indenter.half_width", "indenter.position"})
      result.missing.push_back({name, "on a mesh the contact of a flat changes only where an edge passes a node"});
  else
    result.add({"indenter.position", scene.indenter.position, "mm"}, {.height = -slopes});
  const Sensor& own = scene.sensor;
  Sensor plus = own, minus = own;
  plus.poisson += poisson_step;
  minus.poisson -= poisson_step;
  if (minus.poisson >= 0 && plus.poisson < 0.5)
    result.add({"sensor.poisson", own.poisson, ""}, rubber_direction(plus, minus, 2 * poisson_step, cache_directory));
  else
    result.missing.push_back({"sensor.poisson", "its central difference, 0.001 on both sides, leaves 0 to 0.5"});
  plus = minus = own;
  plus.thickness *= 1 + thickness_step;
  minus.thickness *= 1 - thickness_step;
  result.add({"sensor.thickness", own.thickness, "mm"},
             rubber_direction(plus, minus, 2 * thickness_step * own.thickness, cache_directory));
  return result;
}

}  // namespace tactel::fem
