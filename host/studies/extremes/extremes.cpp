// SPDX-License-Identifier: Apache-2.0
#include "host/studies/extremes/extremes.h"

#include <fmt/format.h>

#include "fem/gap/contact_laws.h"
#include "fem/gap/gap_reference.h"
#include "fem/gap/solution_difference.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch_exact.h"
#include "fem/layer/patch_solver.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_search.h"
#include "host/contact/limits.h"
#include "host/contact/lines/contact_fallback.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/contact/pads/pad_stream.h"

namespace tactel::host {
namespace {

using fem::ContactSolution;
using fem::ContactStep;

struct Answered {
  ContactSolution solution;
  ExtremeAnswer answer;
};

Answered answered(ContactSolution solution) {
  Answered result{std::move(solution), {}};
  result.answer.solved = std::ranges::all_of(result.solution.steps, &ContactStep::converged);
  result.answer.fell_back = result.solution.fell_back;
  for (const ContactStep& step : result.solution.steps) {
    result.answer.iterations = std::max(result.answer.iterations, step.iterations);
    result.answer.residual = std::max(result.answer.residual, fem::largest(step.residual));
  }
  return result;
}

struct Answers {
  std::string model;
  double thickness;  ///< mm
  Answered fp32, fp64, reference;
};

Answered beside(const ContactSolution& reference, const ContactSolution& found) {
  Answered result = answered(found);
  result.answer.off = fem::base_force_difference(found, reference);
  return result;
}

Answers on_mesh(Executor& executor, const fem::Scene& scene) {
  const ContactSolution reference = fem::solve_gap_reference(scene);
  const auto batched = [&](Precision precision) {
    return beside(reference, solve_on_meshes(executor, std::span(&scene, 1), precision).front());
  };
  return {"mesh", scene.sensor.thickness, batched(Precision::fp32), batched(Precision::fp64), answered(reference)};
}

constexpr double twin_tolerance = 1e-9;

/// With the forces of its elements in place of those of a base, which a patch does not have by nodes.
ContactSolution by_elements(ContactSolution patch) {
  for (ContactStep& step : patch.steps)
    step.base_force_x = step.tangential_force, step.base_force_y = step.normal_force;
  return patch;
}

Answers on_patch(Executor& executor, const fem::Scene& scene) {
  Rung rung = usual_patch();
  const fem::LayerModel model = fem::layer_model(scene.sensor);
  const fem::PatchSolver twin(model, {.tolerance = twin_tolerance, .pressing_increments = rung.steps});
  ContactSolution reference;
  const auto batched = [&](Precision precision) {
    rung.precision = precision;
    const ContactSolution found = solve_on_rung(executor, std::span(&scene, 1), rung).front();
    const double half = found.surface_width[0] / 2;
    const fem::Patch patch{found.surface_x[0] - half, found.surface_x[found.surface_x.size() - 1] + half,
                           static_cast<int>(found.surface_x.size())};
    reference = twin.solve_on(patch, scene);
    if (!every_step_converged(reference)) reference = fem::solve_patch_exactly(model, patch, scene, rung.steps);
    reference = by_elements(std::move(reference));
    return beside(reference, by_elements(found));
  };
  Answered fp32 = batched(Precision::fp32), fp64 = batched(Precision::fp64);
  return {"patch", scene.sensor.thickness, std::move(fp32), std::move(fp64), answered(reference)};
}

/// As the answer of a line, with the forces of the cells.
ContactSolution by_cells(const fem::PadSolution& pad) {
  ContactSolution line;
  line.fell_back = pad.fell_back;
  for (const fem::PadStep& from : pad.steps) {
    ContactStep step;
    step.indentation = from.indentation, step.slip_index = from.slip_index, step.converged = from.converged;
    step.iterations = from.iterations, step.residual.penetration = from.residual.largest();
    step.base_force_x = from.tangential_force.reshaped(), step.base_force_y = from.normal_force;
    line.steps.push_back(std::move(step));
  }
  return line;
}

Answers on_pad(Executor& executor, const fem::PadScene& scene) {
  PadModel model = model_of(usual_pad_rung());
  const fem::PadLayer layer = fem::pad_layer(scene);
  const fem::PadSolver twin(layer,
                            {.tolerance = twin_tolerance, .pressing_increments = model.options.pressing_increments});
  ContactSolution reference;
  const auto batched = [&](Precision precision) {
    model.precision = precision;
    const fem::PadSolution found = PadStream(executor, model).solve(std::span(&scene, 1)).front();
    fem::PadScene seen = scene;
    seen.indenter = fem::lay_cells(scene, layer, found.cells.n, true).indenter;
    reference = by_cells(twin.solve_on(found.cells, seen));
    return beside(reference, by_cells(found));
  };
  Answered fp32 = batched(Precision::fp32), fp64 = batched(Precision::fp64);
  return {"pad", scene.sensor.thickness, std::move(fp32), std::move(fp64), answered(reference)};
}

/// Two answers that are both certified and yet differ by more than rounding and sweeps can explain.
constexpr double another_solution = 1e-4;

std::string told(const Answers& answers) {
  const auto& [model, thickness, fp32, fp64, reference] = answers;
  std::vector<std::string> words;
  double deepest = 0;
  for (const ContactStep& step : fp64.solution.steps) deepest = std::max(deepest, step.indentation);
  if (too_deep(thickness, deepest)) words.push_back("warning: depth beyond 20 % of the thickness");
  const auto none = [](const ContactStep& step) { return !step.slip_index; };
  const auto missing = std::ranges::count_if(fp64.solution.steps, none);
  if (missing) words.push_back(fmt::format("S null in {} of {} steps", missing, fp64.solution.steps.size()));
  if (fp32.answer.fell_back) words.push_back("fp32: solved by the fallback");
  if (fp64.answer.fell_back) words.push_back("fp64: solved by the fallback");
  if (!fp32.answer.solved) words.push_back("fp32 NOT converged, exit 4");
  if (!fp64.answer.solved) words.push_back("fp64 NOT converged, exit 4");
  if (!reference.answer.solved) words.push_back("reference NOT converged, exit 4");
  if (fp64.answer.solved && reference.answer.solved && fp64.answer.off > another_solution)
    words.push_back("two certified solutions");
  return fmt::format("{}", fmt::join(words, "; "));
}

Extreme solve_extreme(Executor& executor, const ExtremeScene& extreme) {
  const auto* line = std::get_if<fem::Scene>(&extreme.scene);
  Answers answers = !line                                    ? on_pad(executor, std::get<fem::PadScene>(extreme.scene))
                    : line->model == fem::SurfaceModel::mesh ? on_mesh(executor, *line)
                                                             : on_patch(executor, *line);
  return {answers.model,       extreme.group,       extreme.name,
          answers.fp32.answer, answers.fp64.answer, answers.reference.answer,
          told(answers)};
}

std::string columns_of(const ExtremeAnswer& answer) {
  return fmt::format("{:>6}{} {:>7.0e} {:>7.0e}", answer.iterations,
                     answer.solved ? (answer.fell_back ? "*" : " ") : "!", answer.residual, answer.off);
}

}  // namespace

std::vector<Extreme> scene_extremes(Executor& executor, bool quick, const Progress& progress) {
  std::vector<Extreme> extremes;
  const auto scenes = extreme_scenes(!quick);
  for (const ExtremeScene& extreme : scenes) {
    if (progress && !progress(extremes.size(), scenes.size())) break;
    extremes.push_back(solve_extreme(executor, extreme));
  }
  return extremes;
}

std::string extremes_table(const std::vector<Extreme>& extremes) {
  std::string out = fmt::format(
      "{:<5} {:<19} {:<22} {:^23} {:^23} {:^14}\n{:<5} {:<19} {:<22} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>8}  "
      "{}\n",
      "", "", "", "fp32", "fp64", "reference", "model", "what", "how far", "sweeps", "resid.", "off", "sweeps",
      "resid.", "off", "trials", "resid.", "message to the user");
  for (const Extreme& e : extremes)
    out += fmt::format("{:<5} {:<19} {:<22} {} {} {:>6} {:>8.0e}  {}\n", e.model, e.group, e.name, columns_of(e.fp32),
                       columns_of(e.fp64), e.reference.iterations, e.reference.residual, e.told);
  return out +
         "sweeps, trials: most in one load step; resid.: worst of the certificate; off: forces on the base (mesh), of "
         "elements (patch)\nand cells (pad) beside the reference's: the exact solver (mesh), sweeps in fp64 to 1e-9;\n"
         "*: the sweeps did not converge, the exact fallback answered; !: not converged\n";
}

}  // namespace tactel::host
