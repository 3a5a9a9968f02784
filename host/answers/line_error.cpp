// SPDX-License-Identifier: Apache-2.0
#include "host/answers/line_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem/gap/gap_condensed.h"
#include "fem/gap/gap_reference.h"
#include "fem/gap/load_stepping.h"
#include "fem/layer/end_mesh.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch_reference.h"
#include "fem/layer/patch_solver.h"
#include "fem/mesh/condensation.h"
#include "fem/numbers/cache_directory.h"
#include "fem/numbers/value_error.h"
#include "host/answers/planner.h"
#include "host/contact/lines/contact_fallback.h"

namespace tactel::host {
namespace {

constexpr int most_columns = 81, most_rows = 33;  ///< to condense a mesh of twice as many takes 0.2 s, once
constexpr int most_elements = 48;                 ///< beside which an answer of half as many stands
constexpr std::size_t most_steps = 100;

/// Two answers may agree by chance. Error of S over 1 / elements: with it twice the difference covers the error of 98 %
/// of the contacts with mu 0.02 to 0.1 (docs/notebook/2026-11-23-accuracy.md).
constexpr double chance = 0.04;
/// The same of P where elements are wider than the rubber is thick or carry linear pressures: twice and this over the
/// number covered all of 84 contacts 6 to 60 thicknesses to a side, nu 0.49 to 0.49999; without, 76.
constexpr double twice = 2, chance_of_P = 0.1;

bool has_finer(const fem::Sensor& sensor, std::size_t steps) {
  return sensor.columns <= most_columns && sensor.rows <= most_rows && steps <= most_steps;
}

/// Half the element size in both directions.
fem::Sensor refined(fem::Sensor sensor) {
  sensor.columns = 2 * sensor.columns - 1;
  sensor.rows = 2 * sensor.rows - 1;
  return sensor;
}

constexpr int finer_parts = 2;  ///< of a pressing step

/// The scene on the finer mesh with finer pressing steps, and with as many drags as the answer has.
fem::Scene refined(const fem::Scene& scene, const fem::ContactSolution& answer) {
  fem::Scene fine = scene;
  fine.sensor = refined(scene.sensor);
  const fem::LoadPath path = fem::load_path(scene.load);
  if (path.until_sliding) fine.load.tangential_steps = static_cast<int>(answer.steps.size()) - path.indentation_steps;
  fine.load.indentation_steps *= finer_parts;
  return fine;
}

/// The answer of the finer mesh, by its kept condensation; by the reference near nu = 1/2, where that is not precise
/// enough.
fem::ContactSolution exact_answer(const fem::Scene& fine, const std::filesystem::path& cache) {
  try {
    const fem::Condensation condensation = fem::condense_cached(fine.sensor, cache);
    fem::ContactSolution answer = fem::GapCondensed(condensation).solve(fine);
    if (every_step_converged(answer)) return answer;
  } catch (const ValueError&) {
  }
  return fem::solve_gap_reference(fine);
}

ExpectedError error_beside(const fem::ContactSolution& answer, const fem::ContactSolution& judge, std::string finer) {
  std::vector<std::size_t> steps(std::min(answer.steps.size(), judge.steps.size()));
  std::iota(steps.begin(), steps.end(), 0);
  ExpectedError error{scaled(answer_error(answer, steps, judge, steps), first_order), std::move(finer)};
  error.expected.S = std::min(1.0, error.expected.S);
  return error;
}

/// The scene on another number of elements: by the twin of the patch kernel; exactly where its sweeps do not converge,
/// where the answer is exact, and near an end, where the reference's mesh resolves the corner.
fem::ContactSolution on_elements(const fem::LayerModel& model, const fem::Scene& scene, int elements, bool exact,
                                 bool linear) {
  const fem::PatchOptions twin{.elements = elements};
  if (!exact) {
    fem::ContactSolution answer = fem::PatchSolver(model, twin).solve(scene);
    if (every_step_converged(answer)) return answer;
  }
  const fem::PatchOptions reference{.elements = elements, .pressing_increments = twin.increments(), .linear = linear};
  return fem::PatchReference(model, reference).solve(scene);
}

/// Beside twice as many elements. An answer of many is compared with half as many: to first order the difference is its
/// own error, and twice that is safe.
std::optional<ExpectedError> patch_error(const fem::Scene& scene, const fem::ContactSolution& answer) {
  if (answer.steps.size() > most_steps) return {};
  const int elements = static_cast<int>(answer.surface_width.size());
  const bool many = 2 * elements > most_elements;
  const int others = many ? elements / 2 : 2 * elements;
  const bool linear = answer.linear_elements;
  const bool exact = many || linear || near_end(scene.sensor, answer);
  const fem::LayerModel model = fem::layer_model(scene.sensor);
  const auto error_by = [&](int number) -> std::optional<ExpectedError> {
    const fem::ContactSolution judge = on_elements(model, scene, number, exact, linear);
    if (!every_step_converged(judge)) return {};
    return error_beside(answer, judge, fmt::format("{} elements", number));
  };
  std::optional<ExpectedError> error = error_by(others);
  if (!error) return {};
  // With little friction single elements decide on S, and two numbers of elements agree more often by chance.
  if (scene.friction < least_friction && !many)
    if (const auto finer = error_by(2 * others)) error->expected.S = std::max(error->expected.S, finer->expected.S);
  if (double& P = error->expected.P; P > 0 && (linear || answer.surface_width.maxCoeff() > scene.sensor.thickness))
    P = twice * P + chance_of_P / elements;
  double& S = error->expected.S;
  if (S > 0) S += chance / elements;
  if (S > 0 && (answer.fell_back || !many)) S = std::max(S, model_error(scene, answer));
  S = std::min(1.0, S);
  return error;
}

/// Largest difference and largest value of the second of each pair.
struct Extent {
  double difference = 0, scale = 0;
  void add(double value, double judge) {
    difference = std::max(difference, std::abs(value - judge));
    scale = std::max(scale, std::abs(judge));
  }
  double relative() const { return difference == 0 ? 0 : scale == 0 ? 1 : difference / scale; }
};

void add_tactels(Extent& extent, const Eigen::VectorXd& value, const Eigen::VectorXd& judge) {
  for (Eigen::Index i = 1; i + 1 < value.size(); ++i) extent.add(value[i], judge[i]);
}

}  // namespace

FinerAnswer begin_finer(const fem::Scene& scene) {
  const fem::LoadPath path = fem::load_path(scene.load);
  if (path.until_sliding || !has_finer(scene.sensor, path.steps.size())) return {};
  // The cache is looked up here: the device changes the environment while the thread runs.
  return std::async(std::launch::async, exact_answer, refined(scene, {}), fem::default_cache_directory());
}

std::optional<ExpectedError> mesh_error(const fem::Scene& scene, const fem::ContactSolution& answer,
                                        FinerAnswer finer) {
  if (answer.surface_width.size() > 0) return patch_error(scene, answer);
  if (!has_finer(scene.sensor, answer.steps.size())) return {};
  fem::ContactSolution judge =
      finer.valid() ? finer.get() : exact_answer(refined(scene, answer), fem::default_cache_directory());
  if (!every_step_converged(judge)) return {};
  fem::keep_own_steps(judge, scene.load, finer_parts);
  const fem::Sensor fine = refined(scene.sensor);
  return error_beside(answer, judge, fmt::format("{} x {}", fine.columns, fine.rows));
}

std::string why_no_estimate(const fem::Scene& scene, const fem::ContactSolution& answer) {
  const bool patch = answer.surface_width.size() > 0;
  if (answer.steps.size() > most_steps) return fmt::format("it has more than {} load steps", most_steps);
  if (!patch && !has_finer(scene.sensor, 0))
    return fmt::format("its mesh has more than {} columns or {} rows (--accuracy estimates)", most_columns, most_rows);
  return fmt::format("the {} for comparison could not be solved", patch ? "patch" : "mesh");
}

AnswerError scaled(AnswerError error, double factor) {
  for (const auto member : fem::pad_error_members) error.*member *= factor;
  return error;
}

AnswerError answer_error(const fem::Scene& scene, const fem::ContactSolution& answer, const Rung& rung,
                         const fem::ContactSolution& judge, const Rung& judge_rung) {
  const auto places = asked_steps(on_rung(scene, rung).load, answer.steps.size());
  const auto judge_places = asked_steps(on_rung(scene, judge_rung).load, judge.steps.size());
  return answer_error(answer, places, judge, judge_places);
}

AnswerError answer_error(const fem::ContactSolution& answer, std::span<const std::size_t> steps,
                         const fem::ContactSolution& judge, std::span<const std::size_t> judge_steps) {
  Extent P, Q, sigma, tau;
  AnswerError error;
  for (std::size_t k = 0; k < std::min(steps.size(), judge_steps.size()); ++k) {
    const fem::ContactStep &a = answer.steps[steps[k]], &b = judge.steps[judge_steps[k]];
    if (a.slip_index && b.slip_index)
      error.S = std::max(error.S, std::abs(*a.slip_index - *b.slip_index));
    else if (a.slip_index || b.slip_index)
      error.S = 1;
    P.add(a.P, b.P);
    Q.add(a.Q, b.Q);
    add_tactels(sigma, a.sigma_y, b.sigma_y);
    add_tactels(tau, a.tau_xy, b.tau_xy);
  }
  error.P = P.relative();
  error.Q = Q.relative();
  error.sigma = sigma.relative();
  error.tau = tau.relative();
  return error;
}

bool near_end(const fem::Sensor& sensor, const fem::ContactSolution& answer) {
  const Eigen::VectorXd &x = answer.surface_x, &width = answer.surface_width;
  if (width.size() == 0) return false;
  return fem::near_end(sensor, {x[0] - width[0] / 2, x[x.size() - 1] + width[width.size() - 1] / 2});
}

double model_error(const fem::Scene& scene, const fem::ContactSolution& answer) {
  constexpr double sudden = 0.5, much_friction = 0.5;  // of S between two steps
  if (answer.linear_elements && scene.friction > much_friction)
    for (std::size_t k = 1; k < answer.steps.size(); ++k)
      if (std::abs(answer.steps[k].slip_index.value_or(0) - answer.steps[k - 1].slip_index.value_or(0)) > sudden)
        return 1;
  return near_end(scene.sensor, answer) ? 0.01 + 0.05 * (0.5 - scene.sensor.poisson) : 0;
}

double covering_value(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  const auto count = static_cast<double>(values.size());
  return values[static_cast<std::size_t>(std::clamp(std::ceil(share * count) - 1, 0.0, count - 1))];
}

ErrorQuantiles quantiles(const std::vector<AnswerError>& errors) {
  ErrorQuantiles result;
  for (const auto member : error_members) {
    std::vector<double> values;
    values.reserve(errors.size());
    for (const AnswerError& error : errors) values.push_back(error.*member);
    result.median.*member = covering_value(values, 0.5);
    result.most95.*member = covering_value(values, 0.95);
    result.largest.*member = covering_value(values, 1);
  }
  return result;
}

}  // namespace tactel::host
