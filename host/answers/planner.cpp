// SPDX-License-Identifier: Apache-2.0
#include "host/answers/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/answers/solve.h"
#include "host/contact/lines/sensor_tables.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

/// Errors over the line, outside the mix: twice sufficed for 98 % of 140 scenes, but not for one with mu 0.041 that is
/// pressed by force (docs/notebook/2026-11-23-accuracy.md).
constexpr double beyond_the_mix = 3;

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
  std::vector<AnswerError> differences;
  std::vector<double> estimates, next_estimates;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    AnswerError error = answer_error(scenes[i], answers[i], rung, finer[i], next);
    if (misses_contact(scenes[i], rung, answers[i]) || misses_contact(scenes[i], next, finer[i])) {
      error.S = 1;
      missed = true;
    }
    const bool outside = outside_the_mix(scenes[i], answers[i]) || outside_the_mix(scenes[i], finer[i]);
    differences.push_back(error);
    const auto besides = [&](const Rung& on, const fem::ContactSolution& answer) {
      return on.exact ? 0 : model_error(scenes[i], answer);
    };
    estimates.push_back(std::min(1.0, expected_error(low, error.S, outside) + besides(rung, answers[i])));
    next_estimates.push_back(std::min(1.0, expected_next_error(low, error.S, outside) + besides(next, finer[i])));
  }
  trial.difference = quantiles(differences).most95;
  trial.missed = missed && trial.difference.S >= 1;
  trial.estimate = trial.missed ? 1 : covering_value(estimates, 0.95);
  trial.next_estimate = trial.missed ? 1 : covering_value(next_estimates, 0.95);
  return trial;
}

}  // namespace

double expected_error(std::size_t rung, double difference, bool outside) {
  const MeasuredRung& measured = measured_ladder()[rung];
  const double line = measured.error.at(difference);
  return std::max(difference, outside ? beyond_the_mix * line : std::min(line, measured.most));
}

double expected_next_error(std::size_t rung, double difference, bool outside) {
  const double line = measured_ladder()[rung].next_error.at(difference);
  return std::max(difference, outside ? beyond_the_mix * line : std::min(line, measured_ladder()[rung + 1].most));
}

bool outside_the_mix(const fem::Scene& scene, const fem::ContactSolution& answer) {
  return (scene.friction > 0 && scene.friction < least_friction) || answer.linear_elements ||
         near_end(scene.sensor, answer);
}

RungChoice plan(std::span<const fem::Scene> scenes, double accuracy, const SolveRung& solve) {
  const auto& rungs = ladder();
  RungChoice result{.accuracy = accuracy, .rung = rungs.front()};
  std::vector<fem::ContactSolution> answers = solve(rungs.front());
  for (std::size_t low = 0; low + 1 < rungs.size(); ++low) {
    std::vector<fem::ContactSolution> finer = solve(rungs[low + 1]);
    const PlanTrial& trial = result.trials.emplace_back(compare(scenes, low, answers, finer));
    const bool last = low + 2 == rungs.size();
    const bool enough = trial.estimate <= accuracy, next_enough = trial.next_estimate <= accuracy;
    if (enough || next_enough || last) {
      const std::size_t place = enough ? low : low + 1;
      result.rung = rungs[place];
      result.estimate = enough ? trial.estimate : trial.next_estimate;
      result.kept = enough || next_enough;
      result.answers = std::move(enough ? answers : finer);
      break;
    }
    answers = std::move(finer);
  }
  return result;
}

const Rung& RungChoice::rung_for_many() const {
  return rung.exact ? *std::prev(std::ranges::find(ladder(), true, &Rung::exact)) : rung;
}

std::string RungChoice::why() const {
  const PlanTrial& last = trials.back();
  const std::string& other = last.rung == rung.name ? last.next : last.rung;
  std::string text = fmt::format("rung {} ({}): ", rung.name, description(rung));
  if (last.missed)
    text += fmt::format("this rung or rung {} misses a contact; requested {:g}", other, accuracy);
  else
    text += fmt::format("S differs by {:.2g} on rung {}; expected error in S {:.2g}, requested {:g}", last.difference.S,
                        other, estimate, accuracy);
  return text +
         fmt::format("; the accuracy holds for S alone: sigma_y differs by {:.2g}, tau_xy by {:.2g} of its largest",
                     last.difference.sigma, last.difference.tau);
}

std::optional<ExpectedError> mesh_error(const RungChoice& plan) {
  if (plan.trials.empty() || plan.trials.back().missed) return {};
  const PlanTrial& last = plan.trials.back();
  const bool coarser = last.rung == plan.rung.name;  // else the finest, which differs from the rung below
  ExpectedError error{scaled(last.difference, coarser ? first_order : 1), "rung " + (coarser ? last.next : last.rung)};
  error.expected.S = plan.estimate;
  return error;
}

template <class AnyRung>
std::optional<AnyRung> named_rung_for_many(const SolveOptions& options) {
  check_modelling(options);
  if (options.rung.empty()) return {};
  const AnyRung& rung = rung_named<AnyRung>(options.rung);
  if (rung.exact)
    throw ConfigError("command line", "--rung", options.rung,
                      std::is_same_v<AnyRung, Rung> ? "a rung for many contacts, such as patch-24 or mesh-641: the "
                                                      "reference solves single contacts"
                                                    : "a rung for many scenes, pad-8 to pad-24: the reference solves "
                                                      "single ones");
  return rung;
}
template std::optional<Rung> named_rung_for_many(const SolveOptions&);
template std::optional<PadRung> named_rung_for_many(const SolveOptions&);

RungChoice plan_for_many(Executor& executor, double accuracy, const ManyContacts& contacts) {
  const std::vector<fem::Scene> tried = tried_of(contacts.count, contacts.contact);
  std::shared_ptr<const fem::SensorFamily> family;
  if (contacts.own_sensors)
    family = std::make_shared<const fem::SensorFamily>(sensor_family(executor, *contacts.own_sensors));
  return plan(tried, accuracy, [&](const Rung& rung) { return solve_on_rung(executor, tried, rung, true, family); });
}

std::optional<Rung> rung_for_many(Executor& executor, const SolveOptions& options, const ManyContacts& contacts) {
  if (auto rung = named_rung_for_many(options)) return rung;
  if (!options.accuracy) return {};
  return plan_for_many(executor, *options.accuracy, contacts).rung_for_many();
}

nlohmann::ordered_json to_json(const RungChoice& plan) {
  nlohmann::ordered_json trials = nlohmann::ordered_json::array();
  for (const PlanTrial& t : plan.trials)
    trials.push_back({{"rung", t.rung},
                      {"next", t.next},
                      {"difference", t.difference.S},
                      {"estimate", t.estimate},
                      {"next_estimate", t.next_estimate},
                      {"missed", t.missed},
                      {"sigma_difference", t.difference.sigma},
                      {"tau_difference", t.difference.tau}});
  return {{"accuracy", plan.accuracy},       {"promises", "slip_index"},  {"rung", plan.rung.name},
          {"model", description(plan.rung)}, {"estimate", plan.estimate}, {"kept", plan.kept},
          {"tried", std::move(trials)}};
}

}  // namespace tactel::host
