#include "host/contact/mesh_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem/gap_reference.h"

namespace tactel::host {
namespace {

constexpr int most_columns = 81, most_rows = 33;  ///< the reference takes 0.1 s on twice as many
constexpr std::size_t most_steps = 100;

/// Error over difference from half the element size: contact converges to first order at worst, and so the error
/// halves. Measured of S: 90 % of the scenes have less than 2.1 (measured_ladder).
constexpr double first_order = 2;

/// Half the element size in both directions, and as many drags as the answer has.
fem::Scene refined(const fem::Scene& scene, const fem::ContactSolution& answer) {
  fem::Scene fine = scene;
  fine.sensor.columns = 2 * scene.sensor.columns - 1;
  fine.sensor.rows = 2 * scene.sensor.rows - 1;
  const fem::LoadPath path = fem::load_path(scene.load);
  if (path.until_sliding) fine.load.tangential_steps = static_cast<int>(answer.steps.size()) - path.indentation_steps;
  return fine;
}

/// The measured rung whose mesh is this one's, or the next coarser.
const MeasuredRung& rung_of(const fem::Sensor& sensor) {
  const auto measured = measured_ladder();
  std::size_t place = 1;  // paper: draft has its mesh, and a tolerance that adds to its errors
  while (place + 1 < measured.size() && columns_of(ladder()[place + 1], sensor) <= sensor.columns) ++place;
  return measured[place];
}

AnswerError scaled(const AnswerError& difference, double factor) {
  AnswerError error = difference;
  for (const auto member : error_members) error.*member *= factor;
  return error;
}

}  // namespace

std::optional<MeshError> mesh_error(const fem::Scene& scene, const fem::ContactSolution& answer) {
  const fem::Sensor& sensor = scene.sensor;
  if (sensor.columns > most_columns || sensor.rows > most_rows || answer.steps.size() > most_steps) return {};
  const fem::Scene fine = refined(scene, answer);
  const fem::ContactSolution judge = fem::solve_gap_reference(fine);
  if (!std::ranges::all_of(judge.steps, &fem::ContactStep::converged)) return {};
  std::vector<std::size_t> steps(std::min(answer.steps.size(), judge.steps.size()));
  std::iota(steps.begin(), steps.end(), 0);
  const AnswerError difference = answer_error(answer, steps, judge, steps);
  MeshError error{scaled(difference, first_order), fmt::format("{} x {}", fine.sensor.columns, fine.sensor.rows)};
  const bool touches = std::ranges::any_of(judge.steps, [](const fem::ContactStep& step) { return step.P > 0; });
  if (touches) error.expected.S = std::min(1.0, expected_error(rung_of(sensor), difference.S, touching_nodes(answer)));
  return error;
}

std::optional<MeshError> mesh_error(const Plan& plan) {
  if (plan.trials.empty() || plan.trials.back().missed || !std::isfinite(plan.estimate)) return {};
  const PlanTrial& last = plan.trials.back();
  const bool coarser = last.rung == plan.rung.name;  // else the finest, which differs from the rung below
  const AnswerError difference{.P = last.P, .Q = last.Q, .sigma = last.sigma, .tau = last.tau};
  MeshError error{scaled(difference, coarser ? first_order : 1), "rung " + (coarser ? last.next : last.rung)};
  error.expected.S = plan.estimate;
  return error;
}

}  // namespace tactel::host
