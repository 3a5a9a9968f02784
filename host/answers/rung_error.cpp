// SPDX-License-Identifier: Apache-2.0
#include "host/answers/rung_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/layer/end_mesh.h"

namespace tactel::host {
namespace {

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

ErrorLine error_line(const std::vector<double>& differences, const std::vector<double>& errors, double share) {
  constexpr int slopes = 80;
  constexpr double slope_step = 0.05;
  ErrorLine best;
  double least_loss = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= slopes; ++k) {
    ErrorLine line{.slope = k * slope_step};
    std::vector<double> above;
    for (std::size_t i = 0; i < errors.size(); ++i) above.push_back(errors[i] - line.slope * differences[i]);
    line.least = std::max(0.0, covering_value(above, share));
    double loss = 0;
    for (const double a : above) loss += (a > line.least ? share : share - 1) * (a - line.least);
    if (loss < least_loss) least_loss = loss, best = line;
  }
  return best;
}

ErrorQuantiles quantiles(const std::vector<AnswerError>& errors) {
  ErrorQuantiles result;
  for (const auto member : error_members) {
    std::vector<double> values;
    for (const AnswerError& error : errors) values.push_back(error.*member);
    result.median.*member = covering_value(values, 0.5);
    result.most95.*member = covering_value(values, 0.95);
    result.largest.*member = covering_value(values, 1);
  }
  return result;
}

}  // namespace tactel::host
