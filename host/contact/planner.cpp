// SPDX-License-Identifier: Apache-2.0
#include "host/contact/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/contact/rung_error.h"

namespace tactel::host {
namespace {

constexpr double share_kept = 0.95;  ///< of several scenes

/// Whether an answer shows no contact where the load presses.
bool misses_contact(const fem::Scene& scene, const Rung& rung, const fem::ContactSolution& answer) {
  const fem::Load load = on_rung(scene, rung).load;
  const std::vector<fem::LoadStep> path = fem::load_path(load).steps;
  return std::ranges::any_of(asked_steps(load, answer.steps.size()),
                             [&](std::size_t k) { return path[k].normal > 0 && !(answer.steps[k].P > 0); });
}

/// Rung `low` of the ladder beside the next, on all scenes: the 95 % quantiles.
PlanTrial compare(std::span<const fem::Scene> scenes, std::size_t low, const std::vector<fem::ContactSolution>& answers,
                  const std::vector<fem::ContactSolution>& finer) {
  const Rung &rung = ladder()[low], &next = ladder()[low + 1];
  PlanTrial trial{rung.name, next.name};
  bool missed = false;
  std::size_t at_ends = 0;
  std::vector<double> differences, sigma, tau, P, Q;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    AnswerError error = answer_error(scenes[i], answers[i], rung, finer[i], next);
    if (misses_contact(scenes[i], rung, answers[i]) || misses_contact(scenes[i], next, finer[i])) {
      error.S = 1;
      missed = true;
    }
    at_ends += near_end(scenes[i], answers[i]);
    differences.push_back(error.S);
    sigma.push_back(error.sigma);
    tau.push_back(error.tau);
    P.push_back(error.P);
    Q.push_back(error.Q);
  }
  trial.difference = covering_value(differences, share_kept);
  trial.missed = missed && trial.difference >= 1;
  trial.estimate = trial.missed ? 1 : expected_error(low, trial.difference);
  trial.next_estimate = trial.missed ? 1 : expected_next_error(low, trial.difference);
  if (static_cast<double>(at_ends) > (1 - share_kept) * static_cast<double>(scenes.size()) && !next.exact)
    for (double* estimate : {&trial.estimate, &trial.next_estimate}) *estimate = std::max(*estimate, end_error);
  trial.sigma = covering_value(sigma, share_kept);
  trial.tau = covering_value(tau, share_kept);
  trial.P = covering_value(P, share_kept);
  trial.Q = covering_value(Q, share_kept);
  return trial;
}

}  // namespace

double expected_error(std::size_t rung, double difference) {
  const auto measured = measured_ladder();
  if (rung + 2 == measured.size()) return difference;
  return std::min(measured[rung].error.at(difference), measured[rung].most);
}

double expected_next_error(std::size_t rung, double difference) {
  const auto measured = measured_ladder();
  if (rung + 2 == measured.size()) return measured[rung + 1].most;
  return std::min(measured[rung].next_error.at(difference), measured[rung + 1].most);
}

Plan plan(std::span<const fem::Scene> scenes, double accuracy, const SolveRung& solve) {
  const auto& rungs = ladder();
  Plan result{.accuracy = accuracy, .rung = rungs.front()};
  std::vector<fem::ContactSolution> answers = solve(rungs.front());
  for (std::size_t low = 0; low + 1 < rungs.size(); ++low) {
    std::vector<fem::ContactSolution> finer = solve(rungs[low + 1]);
    const PlanTrial& trial = result.trials.emplace_back(compare(scenes, low, answers, finer));
    const bool last = low + 2 == rungs.size();
    const bool enough = trial.estimate <= accuracy, next_enough = trial.next_estimate <= accuracy;
    if (enough || next_enough || last) {
      const std::size_t place = enough ? low : low + 1;
      result.rung = rungs[place];
      result.model = description(result.rung);
      result.estimate = enough ? trial.estimate : trial.next_estimate;
      result.kept = enough || next_enough;
      result.answers = std::move(enough ? answers : finer);
      break;
    }
    answers = std::move(finer);
  }
  return result;
}

const Rung& Plan::rung_for_many() const { return rung.exact ? ladder()[ladder().size() - 2] : rung; }

std::string Plan::why() const {
  const PlanTrial& last = trials.back();
  const std::string& other = last.rung == rung.name ? last.next : last.rung;
  std::string text = fmt::format("rung {} ({}): ", rung.name, model);
  if (last.missed)
    text += fmt::format("this rung or rung {} misses a contact; requested {:g}", other, accuracy);
  else
    text += fmt::format("S differs by {:.2g} on rung {}; expected error in S {:.2g}, requested {:g}", last.difference,
                        other, estimate, accuracy);
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
                      {"next_estimate", t.next_estimate},
                      {"missed", t.missed},
                      {"sigma_difference", t.sigma},
                      {"tau_difference", t.tau}});
  return {{"accuracy", plan.accuracy}, {"promises", "slip_index"}, {"rung", plan.rung.name},    {"model", plan.model},
          {"estimate", plan.estimate}, {"kept", plan.kept},        {"tried", std::move(trials)}};
}

}  // namespace tactel::host
