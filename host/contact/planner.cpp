#include "host/contact/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/contact/rung_error.h"

namespace tactel::host {
namespace {

/// What the reference may be off by, of its difference from the rung below: its error halves with the mesh at worst.
constexpr double reference_factor = 1;

/// Whether an answer shows no contact where the load presses. The lowest part of an indenter is always over the rubber,
/// so its mesh has no node there.
bool misses_contact(const fem::Scene& scene, const Rung& rung, const fem::ContactSolution& answer) {
  const fem::Load load = on_rung(scene, rung).load;
  const std::vector<fem::LoadStep> path = fem::load_path(load).steps;
  return std::ranges::any_of(asked_steps(load, answer.steps.size()),
                             [&](std::size_t k) { return path[k].normal > 0 && !(answer.steps[k].P > 0); });
}

/// Rung `low` beside a finer one, on all scenes: the 95 % quantiles.
PlanTrial compare(std::span<const fem::Scene> scenes, std::size_t low, const std::vector<fem::ContactSolution>& answers,
                  const std::vector<fem::ContactSolution>& finer) {
  const Rung &rung = ladder()[low], &next = ladder()[finer_rung(low)];
  PlanTrial trial{rung.name, next.name};
  bool missed = false;
  std::vector<double> differences, estimates, sigma, tau, P, Q;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    AnswerError error = answer_error(scenes[i], answers[i], rung, finer[i], next);
    if (misses_contact(scenes[i], rung, answers[i]) || misses_contact(scenes[i], next, finer[i])) {
      error.S = 1;
      missed = true;
    }
    differences.push_back(error.S);
    estimates.push_back(expected_error(measured_ladder()[low], error.S, touching_nodes(answers[i])));
    sigma.push_back(error.sigma);
    tau.push_back(error.tau);
    P.push_back(error.P);
    Q.push_back(error.Q);
  }
  trial.difference = covering_value(differences, 0.95);
  trial.missed = missed && trial.difference >= 1;
  trial.estimate = covering_value(estimates, 0.95);
  trial.sigma = covering_value(sigma, 0.95);
  trial.tau = covering_value(tau, 0.95);
  trial.P = covering_value(P, 0.95);
  trial.Q = covering_value(Q, 0.95);
  return trial;
}

/// How many rungs, from the cheapest on, all sensors carry; the cheapest, cut to fem::most_columns, is always taken for
/// one.
std::size_t carried_rungs(std::span<const fem::Scene> scenes) {
  std::size_t count = 0;
  for (const Rung& rung : ladder()) {
    if (!std::ranges::all_of(scenes, [&](const fem::Scene& scene) { return carries(scene.sensor, rung); })) break;
    ++count;
  }
  return std::max<std::size_t>(count, 1);
}

/// The rung on the scenes' sensors; with the default sensor's columns where these differ.
std::string model_of(std::span<const fem::Scene> scenes, const Rung& rung) {
  const auto here = [&](const fem::Scene& scene) { return description(rung, scene.sensor); };
  const bool alike = !scenes.empty() && std::ranges::all_of(scenes, [&](const fem::Scene& scene) {
    return here(scene) == here(scenes.front());
  });
  return alike ? here(scenes.front()) : description(rung) + " to 20 mm of rubber 1.5 mm thick";
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
  const std::size_t carried = carried_rungs(scenes);
  Plan result{.accuracy = accuracy, .rung = rungs[carried - 1]};
  const auto take = [&](std::size_t place) {
    result.rung = rungs[place];
    result.model = model_of(scenes, rungs[place]);
    result.answers = std::move(answers(place));
    return std::move(result);
  };
  for (std::size_t low = 0; low + 1 < carried; ++low) {
    const std::size_t next = finer_rung(low);
    if (next >= carried) break;
    result.trials.push_back(compare(scenes, low, answers(low), answers(next)));
    result.estimate = result.trials.back().estimate;
    result.kept = result.estimate <= accuracy;
    if (result.kept) return take(low);
  }
  result.estimate = result.trials.empty() ? std::numeric_limits<double>::infinity()
                                          : reference_factor * result.trials.back().difference;
  result.kept = result.estimate <= accuracy;
  return take(carried - 1);
}

std::string Plan::why() const {
  std::string text = fmt::format("rung {} ({})", rung.name, model);
  if (trials.empty())
    return text +
           fmt::format(": this sensor carries no finer rung, so the error in S is unknown; requested {:g}", accuracy);
  const PlanTrial& last = trials.back();
  const std::string& other = last.rung == rung.name ? last.next : last.rung;
  text += last.rung == rung.name ? ": " : ": the finest; ";
  if (last.missed)
    text += fmt::format("the mesh of this rung or of rung {} misses a contact; requested {:g}", other, accuracy);
  else if (last.rung == rung.name)
    text += fmt::format("S differs by {:.2g} on rung {}; expected error in S {:.2g}, requested {:g}", last.difference,
                        other, estimate, accuracy);
  else
    text += fmt::format("S differs by {:.2g} on rung {}; requested {:g}", last.difference, other, accuracy);
  return text +
         fmt::format("; the accuracy holds for S alone: sigma_y differs by {:.2g}, tau_xy by {:.2g} of its largest",
                     last.sigma, last.tau);
}

nlohmann::ordered_json to_json(const Plan& plan) {
  nlohmann::ordered_json trials = nlohmann::ordered_json::array();
  for (const PlanTrial& t : plan.trials)
    trials.push_back({{"rung", t.rung},
                      {"next", t.next},
                      {"difference", t.difference},
                      {"estimate", t.estimate},
                      {"missed", t.missed},
                      {"sigma_difference", t.sigma},
                      {"tau_difference", t.tau}});
  return {{"accuracy", plan.accuracy},
          {"promises", "slip_index"},
          {"rung", plan.rung.name},
          {"model", plan.model},
          {"estimate", std::isfinite(plan.estimate) ? nlohmann::ordered_json(plan.estimate) : nlohmann::ordered_json()},
          {"kept", plan.kept},
          {"tried", std::move(trials)}};
}

}  // namespace tactel::host
