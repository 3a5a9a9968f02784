// SPDX-License-Identifier: Apache-2.0
#include "host/answers/derivatives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "fem/contact_laws.h"
#include "fem/gap_condensed.h"
#include "fem/layer/patch_solver.h"
#include "fem/layer/rigid_contact.h"
#include "fem/load_stepping.h"
#include "fem/scene_numbers.h"
#include "host/scenes/ladder.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr int most_columns = 321;        ///< a solve takes seconds there
constexpr double most_pairs = 1e6;       ///< of a load step and a listed load: minutes
constexpr double another_answer = 0.02;  ///< of S: more than the loosest tolerance of a rung leaves

// Steps of the differences. The sweeps' rounding of 1e-13 over a step leaves 1e-8.
constexpr double step_part = 1e-5, least_size = 0.01;  ///< of a number; one nearer to 0 counts as that large

struct SceneNumber {
  std::string name, unit;
  double* value;
  double step;
};

/// The numbers of a scene by which there are derivatives.
class SceneNumbers {
 public:
  explicit SceneNumbers(fem::Scene& scene);
  std::vector<SceneNumber> all{};

 private:
  void add(const std::string& name, const std::string& unit, double& value) {
    all.push_back({name, unit == "1" ? "" : unit, &value, step_part * std::max(std::abs(value), least_size)});
  }
  void add(const std::string& name, const std::string& unit, std::optional<double>& value) {
    if (value) add(name, unit, *value);
  }
  void add(const std::string& name, const std::string& unit, std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      add(values.size() == 1 ? name : fmt::format("{}[{}]", name, i), unit, values[i]);
  }
  void add(const std::string&, const std::string&, const std::vector<int>&) {}  // powers
  void add_shape(fem::Shape& shape) {
    std::visit(
        [&]<class Kind>(Kind& kind) {
          fem::each_number<Kind>([&](const auto& number) {
            const bool angle = std::string_view(number.unit) == "degrees";
            add(std::string("indenter.") + number.key, angle ? "degree" : number.unit, kind.*number.member);
          });
        },
        shape);
  }
  void add_load(fem::Load& load);
};

SceneNumbers::SceneNumbers(fem::Scene& scene) {
  const bool flat = std::holds_alternative<fem::Flat>(scene.indenter.shape);
  if (!flat) add_shape(scene.indenter.shape);
  if (std::isfinite(scene.friction)) add("contact.friction", "", scene.friction);
  add("sensor.young", "MPa", scene.sensor.young);
  add_load(scene.load);
  add("indenter.position", "mm", scene.indenter.position);
  if (flat) add_shape(scene.indenter.shape);
  add("sensor.poisson", "", scene.sensor.poisson);
  add("sensor.thickness", "mm", scene.sensor.thickness);
}

void SceneNumbers::add_load(fem::Load& load) {
  const bool force = !load.normal_force.empty();
  if (force)
    add("load.normal_force", "N/mm", load.normal_force);
  else
    add("load.indentation", "mm", load.indentation);
  add("load.tangential", "mm", load.tangential);
  if (load.tangential_step != 0) add("load.tangential_step", "mm", load.tangential_step);
  for (std::size_t i = 0; i < load.moves.size(); ++i) {
    const std::string move = fmt::format("load.moves[{}]", i);
    add(move + ".normal", force ? "N/mm" : "mm", load.moves[i].normal);
    add(move + ".tangential", "mm", load.moves[i].tangential);
  }
  add("load.angle", "degree", load.angle);
}

/// A scene's exact solution, and those of scenes beside it on the same patch or mesh.
struct Exact {
  fem::Scene scene;
  fem::ContactSolution solution;
  Eigen::MatrixXd compliance;  ///< of its elements or nodes, as fem::Condensation has it
  std::function<fem::ContactSolution(const fem::Scene&)> solve;
  std::map<std::string, std::string> missing{};  ///< numbers without a derivative, and why

  bool on_patch() const { return solution.surface_width.size() > 0; }
};

bool same_rubber(const fem::Sensor& a, const fem::Sensor& b) {
  return a.poisson == b.poisson && a.thickness == b.thickness;
}

/// Whether the tables of patches have as many rows: then their errors, some 1e-6, do not show in differences.
bool same_tables(const fem::Sensor& a, const fem::Sensor& b) {
  const fem::Sensor of_a = fem::side_block(a), of_b = fem::side_block(b);
  return fem::BaseStressTable::places(a) == fem::BaseStressTable::places(b) && of_a.columns == of_b.columns &&
         fem::FreeSides::places(of_a, a.length) == fem::FreeSides::places(of_b, b.length);
}

/// The patch of a scene beside `from`, which has this one: it goes along with the indenter, and stretches with a flat.
fem::Patch moved_patch(fem::Patch patch, const fem::Indenter& from, const fem::Indenter& to) {
  if (patch.reaches_left || patch.reaches_right) return patch;
  const auto half_width = [](const fem::Indenter& indenter) {
    const auto* flat = std::get_if<fem::Flat>(&indenter.shape);
    return flat ? flat->half_width.value_or(1) : 1;
  };
  for (double* end : {&patch.left, &patch.right})
    *end = to.position + (*end - from.position) * half_width(to) / half_width(from);
  return patch;
}

Exact exact_patch(fem::Scene scene, const Rung& rung) {
  const auto model_of = [sides = rung.sides](const fem::Sensor& sensor) {
    return sides ? fem::layer_model(sensor) : fem::endless_layer(sensor);
  };
  scene.indenter = fem::with_hull(scene.indenter);
  const fem::PatchOptions options{.elements = rung.elements,
                                  .tolerance = 1e-13,
                                  .accept = 1e-9,
                                  .pressing_increments = rung.steps,
                                  .most_sweeps = 20000};
  const auto model = std::make_shared<const fem::LayerModel>(model_of(scene.sensor));
  fem::Patch patch;
  Exact exact{scene, fem::PatchSolver(*model, options).solve(scene, &patch), {}, {}};
  exact.compliance = fem::patch_condensation(*model, patch).compliance;
  exact.solve = [=](const fem::Scene& beside) {
    const fem::Patch moved = moved_patch(patch, scene.indenter, beside.indenter);
    if (same_rubber(beside.sensor, scene.sensor)) return fem::PatchSolver(*model, options).solve_on(moved, beside);
    return fem::PatchSolver(model_of(beside.sensor), options).solve_on(moved, beside);
  };
  if (const auto* flat = std::get_if<fem::Flat>(&scene.indenter.shape)) {
    if (patch.reaches_left || patch.reaches_right)
      exact.missing["indenter.position"] = "the flat reaches an end of the sensor";
    if (flat->half_width && !(patch.edge_left && patch.edge_right))
      exact.missing["indenter.half_width"] = "an edge of the flat lies beyond the sensor";
  }
  return exact;
}

/// `parts`: of each pressing step.
Exact exact_mesh(const fem::Scene& scene, int parts) {
  const auto rubber_of = [](const fem::Sensor& sensor) {
    return std::make_shared<const fem::Condensation>(fem::condense_cached(sensor, fem::default_cache_directory()));
  };
  const auto solve = [=, own = scene.sensor, rubber = rubber_of(scene.sensor)](fem::Scene beside) {
    const fem::Load load = beside.load;
    beside.load.indentation_steps *= parts;
    const auto other = same_rubber(beside.sensor, own) ? rubber : rubber_of(beside.sensor);
    fem::ContactSolution solution = fem::GapCondensed(*other).solve(beside);
    fem::keep_own_steps(solution, load, parts);
    return solution;
  };
  Exact exact{scene, solve(scene), rubber_of(scene.sensor)->compliance, solve};
  if (std::holds_alternative<fem::Flat>(scene.indenter.shape))
    for (const char* name : {"indenter.half_width", "indenter.position"})
      exact.missing[name] = "on a mesh the contact of a flat changes only where an edge passes a node";
  return exact;
}

[[noreturn]] void refuse(const SolveOutcome& outcome, const std::string& allowed) {
  throw ConfigError("command line", "--derivatives", model_name(outcome), allowed);
}

/// Every listed load is a parameter: twice as many solves.
void check_pairs(const fem::Load& load, std::size_t steps) {
  const std::size_t listed = load.indentation.size() + load.normal_force.size() + load.tangential.size();
  if (static_cast<double>(listed) * static_cast<double>(steps) <= most_pairs) return;
  throw ConfigError("command line", "--derivatives", fmt::format("{} load steps, {} of them listed", steps, listed),
                    "left out for a path with more than 1000000 pairs of a load step and a listed load");
}

Exact exact_of(const fem::Scene& scene, const SolveOutcome& outcome) {
  const Rung* rung = !outcome.rung.empty() ? &rung_named(outcome.rung) : nullptr;
  if (rung && rung->exact && outcome.on_patch())
    refuse(outcome, "a patch or a mesh, such as --rung patch-24, instead of the reference of patches");
  if (outcome.solution.linear_elements)
    refuse(outcome, "a mesh, or a contact that is narrower beside the rubber's thickness");
  if (outcome.on_patch()) return exact_patch(scene, rung ? *rung : usual_patch());
  const fem::Sensor& sensor = outcome.scene.sensor;
  if (sensor.columns > most_columns) refuse(outcome, fmt::format("a mesh of at most {} columns", most_columns));
  // A scene of a patch that a mesh answered has the patch's increments.
  const bool from_patch = rung ? rung->patch() : scene.model == fem::SurfaceModel::patch;
  const Rung& own = rung ? *rung : usual_patch();
  return exact_mesh(outcome.scene, from_patch ? fem::pressing_parts(scene.load, own.steps) : 1);
}

double difference_of_S(const fem::ContactSolution& solution, const fem::ContactSolution& exact) {
  double most = 0;
  for (std::size_t k = 0; k < exact.steps.size(); ++k)
    most = std::max(most, std::abs(solution.steps[k].slip_index.value_or(0) - exact.steps[k].slip_index.value_or(0)));
  return most;
}

fem::ContactStep difference(const fem::ContactStep& a, const fem::ContactStep& b, double distance) {
  fem::ContactStep by;
  for (const auto member :
       {&fem::ContactStep::P, &fem::ContactStep::Q, &fem::ContactStep::indentation, &fem::ContactStep::tangential})
    by.*member = (a.*member - b.*member) / distance;
  if (a.slip_index && b.slip_index) by.slip_index = (*a.slip_index - *b.slip_index) / distance;
  by.sigma_y = (a.sigma_y - b.sigma_y) / distance;
  by.tau_xy = (a.tau_xy - b.tau_xy) / distance;
  return by;
}

/// What a step's forces do to the elements. u: their displacement [x, y by element] mm, in and out.
fem::GapElements elements_of(const Exact& exact, const fem::ContactStep& step, double last_x, Eigen::VectorXd& u) {
  const Eigen::VectorXd height = fem::profile_heights(exact.scene.indenter, exact.solution.surface_x), before = u;
  fem::GapElements e{
      std::min(exact.scene.friction, fem::largest_friction), {}, {}, step.normal_force, step.tangential_force};
  Eigen::VectorXd force(2 * height.size());
  force << step.tangential_force, -step.normal_force;
  u = exact.compliance * force.reshaped(height.size(), 2).transpose().reshaped() / exact.scene.sensor.young;
  e.gap = height - u(Eigen::seq(1, Eigen::last, 2));
  e.gap.array() -= step.indentation;
  e.slip = (u - before)(Eigen::seq(0, Eigen::last, 2));
  e.slip.array() -= step.tangential - last_x;
  e.largest_displacement = u.cwiseAbs().maxCoeff();
  return e;
}

/// How near a contact is to another status: the smallest gap of open elements, n, mu n - |t| of sticking and |slip| of
/// slipping ones, over the largest displacement, n or mu n. Slip counts where something moved.
double distance_to_switch(const fem::GapElements& e) {
  const std::vector<fem::GapStatus> status = fem::gap_status(e);
  const double normal = e.normal_force.maxCoeff(), length = e.largest_displacement > 0 ? e.largest_displacement : 1;
  const bool moved = e.slip.cwiseAbs().maxCoeff() > fem::force_rounding * length;
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < e.gap.size(); ++i) {
    const double n = e.normal_force[i], t = std::abs(e.tangential_force[i]);
    const fem::GapStatus own = status[static_cast<std::size_t>(i)];
    nearest = std::min(nearest, own == fem::GapStatus::open ? e.gap[i] / length : n / normal);
    if (own == fem::GapStatus::stick) nearest = std::min(nearest, (e.mu * n - t) / (e.mu * normal));
    if (own == fem::GapStatus::slip && e.mu > 0 && moved) nearest = std::min(nearest, std::abs(e.slip[i]) / length);
  }
  return std::max(0.0, nearest);
}

/// [steps] the smallest up to each.
std::vector<double> distances_to_switch(const Exact& exact) {
  std::vector<double> nearest;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(2 * exact.solution.surface_x.size());
  double x = 0;
  for (const fem::ContactStep& step : exact.solution.steps) {
    const double own = distance_to_switch(elements_of(exact, step, std::exchange(x, step.tangential), u));
    nearest.push_back(nearest.empty() ? own : std::min(own, nearest.back()));
  }
  return nearest;
}

bool converged(const fem::ContactSolution& solution) {
  return std::ranges::all_of(solution.steps, &fem::ContactStep::converged);
}

/// The scene with a number changed; none where it has no such value, other tables, or is not solved.
std::optional<fem::ContactSolution> solved_beside(const Exact& exact, std::size_t number, double by) try {
  fem::Scene scene = exact.scene;
  *SceneNumbers(scene).all[number].value += by;
  if (exact.on_patch() && !same_tables(scene.sensor, exact.scene.sensor)) return std::nullopt;
  fem::ContactSolution solution = exact.solve(scene);
  if (!converged(solution)) return std::nullopt;
  return solution;
} catch (const ValueError&) {
  return std::nullopt;
}

/// By one number, [steps]; none where nothing beside it is solved.
std::vector<fem::ContactStep> differentiate(const Exact& exact, std::size_t number, double step) {
  const auto plus = solved_beside(exact, number, step), minus = solved_beside(exact, number, -step);
  if (!plus && !minus) return {};
  const fem::ContactSolution &to = plus ? *plus : exact.solution, &from = minus ? *minus : exact.solution;
  std::vector<fem::ContactStep> by;
  for (std::size_t k = 0; k < exact.solution.steps.size(); ++k)
    by.push_back(difference(to.steps[k], from.steps[k], plus && minus ? 2 * step : step));
  return by;
}

}  // namespace

ContactDerivatives derivatives(const fem::Scene& scene, const SolveOutcome& outcome) {
  const std::size_t steps = outcome.solution.steps.size();
  check_pairs(scene.load, steps);
  Exact exact = exact_of(scene, outcome);
  if (!converged(exact.solution)) refuse(outcome, "a scene whose exact solution is found");
  if (exact.solution.steps.size() != steps) refuse(outcome, "a scene whose exact path has as many steps");
  ContactDerivatives result;
  result.answer_difference = difference_of_S(outcome.solution, exact.solution);
  if (!(result.answer_difference <= another_answer))
    refuse(outcome,
           fmt::format("a contact with one solution: S of the exact path is off by {:.2g}", result.answer_difference));
  if (fem::LoadPath path = fem::load_path(exact.scene.load); path.until_sliding)  // it ends where the answer does
    exact.scene.load.tangential_steps = static_cast<int>(steps) - path.indentation_steps;
  if (std::holds_alternative<fem::Profile>(exact.scene.indenter.shape))
    result.missing.push_back({"indenter.y", "the points of a measured profile are not parameters"});
  if (!std::isfinite(exact.scene.friction)) result.missing.push_back({"contact.friction", "the contact is bonded"});
  const std::vector<SceneNumber> numbers = SceneNumbers(exact.scene).all;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto& [name, unit, value, step] = numbers[i];
    const auto known = exact.missing.find(name);
    std::vector<fem::ContactStep> by;
    if (known == exact.missing.end()) by = differentiate(exact, i, step);
    if (by.empty()) {
      result.missing.push_back({name, known != exact.missing.end() ? known->second : "no contact beside it is solved"});
      continue;
    }
    result.parameters.push_back({name, *value, unit});
    result.by.push_back(std::move(by));
  }
  result.distance_to_switch = distances_to_switch(exact);
  return result;
}

}  // namespace tactel::host
