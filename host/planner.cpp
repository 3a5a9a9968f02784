#include "host/planner.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/rung_error.h"

namespace tactel::host {
namespace {

/// What the reference may be off by, of its difference from the rung below: its error halves with the mesh at worst.
constexpr double reference_factor = 1;

/// Rung `low` beside a finer one, on all scenes: the 95 % quantiles.
PlanTrial compare(std::span<const fem::Scene> scenes, std::size_t low, const std::vector<fem::ContactSolution>& answers,
                  const std::vector<fem::ContactSolution>& finer) {
  const Rung &rung = ladder()[low], &next = ladder()[finer_rung(low)];
  std::vector<double> differences, estimates;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    differences.push_back(answer_error(scenes[i], answers[i], rung, finer[i], next).S);
    estimates.push_back(expected_error(measured_ladder()[low], differences.back(), touching_nodes(answers[i])));
  }
  return {rung.name, next.name, quantile(differences, 0.95), quantile(estimates, 0.95)};
}

}  // namespace

std::size_t touching_class(int nodes) {
  return static_cast<std::size_t>(std::ranges::count_if(most_touching, [&](int most) { return nodes > most; }));
}

int touching_nodes(const fem::ContactSolution& solution) {
  std::ptrdiff_t most = 0;
  for (const fem::ContactStep& step : solution.steps)
    most = std::max<std::ptrdiff_t>(most, (step.normal_force.array() > 0).count());
  return static_cast<int>(most);
}

double expected_error(const MeasuredRung& rung, double difference, int touching) {
  return std::max(rung.factor * difference, rung.least[touching_class(touching)]);
}

std::size_t finer_rung(std::size_t low) {
  const auto& rungs = ladder();
  std::size_t next = low + 1;
  while (next + 1 < rungs.size() && rungs[next].columns <= rungs[low].columns) ++next;
  return next;
}

Plan plan(std::span<const fem::Scene> scenes, double accuracy, const SolveRung& solve) {
  const auto& rungs = ladder();
  std::vector<std::optional<std::vector<fem::ContactSolution>>> known(rungs.size());
  const auto answers = [&](std::size_t place) -> std::vector<fem::ContactSolution>& {
    if (!known[place]) known[place] = solve(rungs[place]);
    return *known[place];
  };
  Plan result{.accuracy = accuracy, .rung = rungs.back()};
  for (std::size_t low = 0; low + 1 < rungs.size(); ++low) {
    result.trials.push_back(compare(scenes, low, answers(low), answers(finer_rung(low))));
    result.estimate = result.trials.back().estimate;
    result.kept = result.estimate <= accuracy;
    if (!result.kept) continue;
    result.rung = rungs[low];
    result.answers = std::move(answers(low));
    return result;
  }
  result.estimate = reference_factor * result.trials.back().difference;
  result.kept = result.estimate <= accuracy;
  result.answers = std::move(answers(rungs.size() - 1));
  return result;
}

std::string Plan::why() const {
  std::string text = fmt::format("rung {} ({})", rung.name, description(rung));
  const PlanTrial& last = trials.back();
  if (last.rung == rung.name)
    return text + fmt::format(": S differs by {:.2g} on rung {}; error in S to expect {:.2g}, asked for {:g}",
                              last.difference, last.next, estimate, accuracy);
  return text + fmt::format(": the finest; S differs by {:.2g} on rung {}; asked for {:g}", last.difference, last.rung,
                            accuracy);
}

nlohmann::ordered_json to_json(const Plan& plan) {
  nlohmann::ordered_json trials = nlohmann::ordered_json::array();
  for (const PlanTrial& t : plan.trials)
    trials.push_back({{"rung", t.rung}, {"next", t.next}, {"difference", t.difference}, {"estimate", t.estimate}});
  return {{"accuracy", plan.accuracy}, {"rung", plan.rung.name}, {"model", description(plan.rung)},
          {"estimate", plan.estimate}, {"kept", plan.kept},      {"tried", std::move(trials)}};
}

}  // namespace tactel::host
