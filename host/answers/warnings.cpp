// SPDX-License-Identifier: Apache-2.0
#include "host/answers/warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "fem/gap/stress_field.h"
#include "fem/pad/pad_presses.h"
#include "host/answers/answer_forms.h"
#include "host/contact/limits.h"
#include "host/scenes/ladder.h"
#include "host/scenes/unit_warnings.h"

namespace tactel::host {
namespace {

constexpr double doubtful_forces = 1e-3;  ///< estimated error of base forces from which on fp32 is doubted
constexpr double near_edge = 2;           ///< thicknesses from an edge
constexpr double large_error = 0.05;      ///< of S, and of P

// ---- of lines and pads

/// Of indentations beyond those to which rubber is linear.
std::optional<std::string> depth_warning(double thickness, const auto& steps) {
  double deepest = 0;
  for (const auto& step : steps) deepest = std::max(deepest, step.indentation);
  if (!too_deep(thickness, deepest)) return std::nullopt;
  return fmt::format(
      "the indenter is {:.3g} mm deep, {:.0f} % of the thickness; rubber was measured to be linear up to {:.0f} %",
      deepest, 100 * deepest / thickness, 100 * fem::linear_strain_limit);
}

/// `limit(step)`: how far the indenter may slide, mm; 0: nothing touches. `places`: over which its profile stays.
std::optional<std::string> slip_warning(const auto& steps, const char* places, const auto& limit) {
  double worst = 1, limit_there = 0, slid = 0;
  for (const auto& step : steps)
    if (const double most = limit(step); most > 0 && step.slip_distance / most > worst)
      worst = step.slip_distance / most, limit_there = most, slid = step.slip_distance;
  if (limit_there == 0) return std::nullopt;
  return fmt::format(
      "the indenter slides {:.3g} mm over the rubber, more than {:.3g} mm: the model assumes small displacements, "
      "and its profile stays over the {} of its first position",
      slid, limit_there, places);
}

/// Of steps that touch nothing, and those of them that are pressed.
std::optional<std::string> untouched_warning(const auto& steps) {
  std::vector<std::size_t> untouched, pressed;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (steps[k].P != 0) continue;
    untouched.push_back(k + 1);
    if (steps[k].indentation > 0) pressed.push_back(k + 1);
  }
  if (untouched.empty()) return std::nullopt;
  std::string text = "the indenter touches nothing in " + steps_text(untouched);
  if (!pressed.empty())
    text += fmt::format("; in {} it should: the contact is smaller than what the model resolves there",
                        pressed.size() == untouched.size() ? "all of them" : steps_text(pressed));
  return text;
}

/// Steps whose contact extends over few cells or elements.
struct FewInSteps {
  std::string steps;  ///< as steps_text
  int fewest = 0;     ///< in any of them
};
/// `across`: the cells or elements of each step, of which some but fewer than `least` are few.
std::optional<FewInSteps> few_in_steps(const std::vector<int>& across, int least) {
  std::vector<std::size_t> numbers;
  int fewest = least;
  for (std::size_t k = 0; k < across.size(); ++k) {
    if (across[k] == 0 || across[k] >= least) continue;
    numbers.push_back(k + 1);
    fewest = std::min(fewest, across[k]);
  }
  if (numbers.empty()) return std::nullopt;
  return FewInSteps{steps_text(numbers), fewest};
}

// ---- of lines

/// Of the contact of a step: slip_limit.
double slip_limit_of(const fem::Sensor& sensor, const fem::ContactSolution& solution, const fem::ContactStep& step) {
  const auto touching = step.normal_force.array() > 0;
  if (solution.surface_width.size() > 0)
    return slip_limit(sensor, touching.select(solution.surface_width.array(), 0.0).sum());
  return slip_limit(sensor, sensor.length / (sensor.columns - 1) * static_cast<double>(touching.count()));
}

/// On patches, whose elements are laid for the deepest step.
std::optional<std::string> few_elements_warning(const fem::ContactSolution& solution) {
  if (solution.surface_width.size() == 0) return std::nullopt;
  std::vector<int> touched;
  for (const fem::ContactStep& step : solution.steps)
    touched.push_back(static_cast<int>((step.normal_force.array() > 0).count()));
  const auto few = few_in_steps(touched, fem::least_elements);
  if (!few) return std::nullopt;
  return fmt::format(
      "in {} the contact covers {} of {} elements, which are laid for the deepest step: its forces are coarse; a scene "
      "of that depth alone is finer",
      few->steps, few->fewest, solution.surface_width.size());
}

// ---- of pads

std::optional<std::string> edge_warning(const PadOutcome& outcome) {
  const auto distance = distance_to_edge(outcome.scene, outcome.solution);
  if (!distance || *distance >= near_edge * outcome.scene.sensor.thickness) return std::nullopt;
  const double over = *distance / outcome.scene.sensor.thickness;
  return fmt::format(
      "the contact comes within {:.3g} mm ({:.2g} thicknesses) of the pad's edge: the model has no free sides, which "
      "puts S of lines off by {}",
      *distance, over, error_at_edge(over));
}

std::optional<std::string> error_warning(const PadOutcome& outcome) {
  if (!outcome.error) return std::nullopt;
  const double S = outcome.error->expected.S, P = outcome.error->expected.P - outcome.error->strain;  // by the cells
  if (S <= large_error && P <= large_error) return std::nullopt;
  return fmt::format("S may be off by {:.2g} and P by {}: take a rung with more cells", S, percent(P));
}

/// Of depths at which rubber is not linear.
std::optional<std::string> strain_warning(const PadOutcome& outcome) {
  const double H = outcome.scene.sensor.thickness, depth = deepest(outcome.scene, outcome.solution);
  constexpr double rounding = 1e-6;  // of a depth in fp32
  if (!has_flat_face(outcome.scene) || depth <= deep_face * (1 + rounding) * H)
    return too_deep(H, depth) ? depth_warning(H, outcome.solution.steps) : std::nullopt;
  return fmt::format(
      "the face is {:.3g} mm deep, {:.0f} % of the thickness: by large strain, which the model leaves out, rubber is "
      "some {} stiffer there",
      depth, 100 * depth / H, percent(strain_error(outcome.scene, outcome.solution)));
}

/// Error of P of a step whose contact extends over so few cells: fem::least_across.
double coarse_error(int across) { return across >= 5 ? 0.02 : across >= 3 ? 0.08 : 1; }

/// Steps that hold a history of friction cannot have cells of their own.
std::optional<std::string> few_cells_warning(const PadOutcome& outcome) {
  std::vector<int> across;
  for (const fem::PadStep& step : outcome.solution.steps) across.push_back(step.across);
  const int cells = outcome.solution.cells.n, widest = across.empty() ? 0 : std::ranges::max(across);
  const auto few = few_in_steps(across, fem::least_across(cells, widest));
  if (!few) return std::nullopt;
  return fmt::format(
      "in {} the contact extends over {} of {} cells, which are laid for the deepest step: P there may be off by "
      "{} and S is coarse",
      few->steps, few->fewest, cells, percent(coarse_error(few->fewest)));
}

std::optional<std::string> pitch_warning(const PadOutcome& outcome) {
  const fem::PadSensor& sensor = outcome.scene.sensor;
  if (!wide_pitch(sensor)) return std::nullopt;
  const double H = sensor.thickness, pitch = std::max(sensor.pitch[0], sensor.pitch[1]);
  const Eigen::MatrixX2d tactels = fem::tactel_places(sensor);
  double nearest = std::numeric_limits<double>::infinity();
  const auto& [steps, places] = std::tie(outcome.solution.steps, outcome.solution.places);
  for (Eigen::Index i = 0; i < places.rows(); ++i)
    if (std::ranges::any_of(steps, [i](const fem::PadStep& step) { return step.normal_force[i] > 0; }))
      nearest = std::min(nearest, (tactels.rowwise() - places.row(i)).rowwise().norm().minCoeff());
  if (!far_from_tactels(sensor, nearest)) return std::nullopt;
  return fmt::format(
      "the contact stays {:.3g} mm from the nearest tactel, more than the thickness of {:.3g} mm: with a pitch of "
      "{:.3g} mm the tactels hardly see it",
      nearest, H, pitch);
}

/// Of skins for which a flat layer stands, with radii below 20 H.
std::optional<std::string> curvature_warning(const fem::PadSensor& sensor) {
  if (!sensor.curvature_radius || *sensor.curvature_radius >= 20 * sensor.thickness) return std::nullopt;
  return fmt::format(
      "the skin's radius is {:.3g} thicknesses: the flat layer that stands for it bears up to {} too much; of 20 "
      "thicknesses 3 %, of 10 7 %",
      *sensor.curvature_radius / sensor.thickness, percent(curvature_error(sensor)));
}

/// The warnings that there are.
std::vector<std::string> those_of(std::vector<std::string> all,
                                  std::initializer_list<std::optional<std::string>> more) {
  for (const auto& warning : more)
    if (warning) all.push_back(*warning);
  return all;
}

}  // namespace

std::string steps_text(const std::vector<std::size_t>& numbers) {
  std::string text;
  for (std::size_t first = 0, end = 0; first < numbers.size(); first = end) {
    end = first + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", numbers[first]);
    if (end > first + 1) text += fmt::format(" to {}", numbers[end - 1]);
  }
  return (numbers.size() > 1 ? "load steps " : "load step ") + text;
}

bool never_slid(const fem::Scene& scene, const fem::ContactSolution& solution) {
  return fem::load_path(scene.load).until_sliding && !solution.sliding;
}

std::vector<std::string> warnings(const SolveOutcome& outcome) {
  const auto& [scene, solution] = std::tie(outcome.scene, outcome.solution);
  const auto limit = [&](const fem::ContactStep& step) {
    return slip_limit_of(outcome.scene.sensor, outcome.solution, step);
  };
  auto all = those_of(unit_warnings(scene), {depth_warning(scene.sensor.thickness, solution.steps),
                                             slip_warning(solution.steps, "nodes", limit),
                                             untouched_warning(solution.steps), few_elements_warning(solution)});
  if (never_slid(scene, solution) && !solution.steps.empty() && !(solution.steps.back().P > 0))
    all.push_back("the drag until sliding touches nothing: it ends with its first step");
  else if (never_slid(scene, solution))
    all.push_back(fmt::format("the contact does not slide as a whole within {} steps of {:.3g} mm",
                              fem::most_tangential_steps, scene.load.tangential_step));
  const auto raised = [](const fem::ContactStep& step) { return step.P > 0 && step.indentation < 0; };
  if (const auto step = std::ranges::find_if(solution.steps, raised); step != solution.steps.end())
    all.push_back(
        fmt::format("in step {} friction holds the indenter {:.3g} mm above its first touch under P = {:.3g} "
                    "N/mm: other solutions are likely (docs/accuracy.md)",
                    step - solution.steps.begin() + 1, -step->indentation, step->P));
  if (solution.several)
    all.push_back(
        fmt::format("this contact has several solutions: with friction {:g} Coulomb's law does not determine "
                    "it uniquely (docs/accuracy.md)",
                    scene.friction));
  if (solution.base_force_error > doubtful_forces)
    all.push_back(
        fmt::format("in fp32 single base forces may be off by some {:.1g} of the largest, more than the residual "
                    "shows: fp64 resolves them (docs/accuracy.md)",
                    solution.base_force_error));
  if (!outcome.rung.name.empty() && !carries(scene.sensor, outcome.rung))
    all.push_back(fmt::format("rung {} requires more than the {} columns that a mesh may have: its mesh is coarser, {}",
                              outcome.rung.name, fem::most_columns, description(outcome.rung, scene.sensor)));
  if (!scene.sensor.layers.empty())
    all.push_back("errors were not measured for scenes like this one: layers upon layers");
  if (!outcome.no_estimate.empty())
    all.push_back(fmt::format("the error of this answer is not estimated: {}", outcome.no_estimate));
  return all;
}

std::vector<std::string> warnings(const PadOutcome& outcome) {
  const auto& steps = outcome.solution.steps;
  const auto limit = [](const fem::PadStep& step) { return slip_limit(std::sqrt(step.area)); };
  auto all = those_of(unit_warnings(outcome.scene),
                      {strain_warning(outcome), untouched_warning(steps), few_cells_warning(outcome),
                       slip_warning(steps, "cells", limit), error_warning(outcome), edge_warning(outcome),
                       pitch_warning(outcome), curvature_warning(outcome.scene.sensor)});
  if (outcome.error)
    for (const std::string& what : outcome.error->outside)
      all.push_back("errors were not measured for scenes like this one: " + what);
  return all;
}

}  // namespace tactel::host
