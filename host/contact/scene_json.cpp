// SPDX-License-Identifier: Apache-2.0
#include "host/contact/scene_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/contact/convergence.h"
#include "host/contact/derivatives.h"
#include "host/contact/json_values.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

Json residual_json(const fem::Residual& r) {
  return {{"penetration", r.penetration},
          {"cone", r.cone},
          {"complementarity", r.complementarity},
          {"drift", r.drift},
          {"balance", r.balance}};
}

/// `base`: with the forces of base nodes, which a patch lacks.
Json step_json(const fem::ContactStep& step, bool base) {
  return {{"indentation", step.indentation},
          {"tangential", step.tangential},
          {"P", step.P},
          {"Q", step.Q},
          {"slip_index", step.slip_index ? Json(*step.slip_index) : Json()},
          {"slip_distance", step.slip_distance},
          {"status", json_statuses(step.status)},
          {"normal_force", json_numbers(step.normal_force)},
          {"tangential_force", json_numbers(step.tangential_force)},
          {"base_force_x", base ? json_numbers(step.base_force_x) : Json::array()},
          {"base_force_y", base ? json_numbers(step.base_force_y) : Json::array()},
          {"sigma_y", json_numbers(step.sigma_y)},
          {"tau_xy", json_numbers(step.tau_xy)},
          {"converged", step.converged},
          {"iterations", step.iterations},
          {"residual", residual_json(step.residual)}};
}

Json mesh_error_json(const MeshError& error) {
  const AnswerError& e = error.expected;
  return {{"slip_index", e.S}, {"P", e.P}, {"Q", e.Q}, {"sigma_y", e.sigma}, {"tau_xy", e.tau}, {"from", error.finer}};
}

Json derivatives_json(const ContactDerivatives& derivatives) {
  Json parameters = Json::array(), missing = Json::array(), steps = Json::array();
  for (const fem::SceneParameter& p : derivatives.parameters)
    parameters.push_back({{"name", p.name}, {"value", p.value}, {"unit", p.unit}});
  for (const fem::NoDerivative& m : derivatives.missing) missing.push_back({{"name", m.name}, {"reason", m.reason}});
  for (std::size_t k = 0; k < derivatives.distance_to_switch.size(); ++k) {
    const Json none = Json::array();
    Json P = none, Q = none, S = none, depth = none, x = none, sigma = none, tau = none;
    for (const std::vector<fem::PathAnswer>& by : derivatives.by) {
      const fem::PathAnswer& a = by[k];
      P.push_back(a.P);
      Q.push_back(a.Q);
      S.push_back(a.S ? Json(*a.S) : Json());
      depth.push_back(a.depth);
      x.push_back(a.x);
      sigma.push_back(json_numbers(a.frame.head(a.frame.size() / 2)));
      tau.push_back(json_numbers(a.frame.tail(a.frame.size() / 2)));
    }
    steps.push_back({{"distance_to_switch", derivatives.distance_to_switch[k]},
                     {"P", std::move(P)},
                     {"Q", std::move(Q)},
                     {"slip_index", std::move(S)},
                     {"indentation", std::move(depth)},
                     {"tangential", std::move(x)},
                     {"sigma_y", std::move(sigma)},
                     {"tau_xy", std::move(tau)}});
  }
  return {{"parameters", std::move(parameters)},
          {"missing", std::move(missing)},
          {"answer_difference", derivatives.answer_difference},
          {"steps", std::move(steps)}};
}

}  // namespace

Json to_json(const fem::Scene& scene, const SolveOutcome& outcome) {
  const fem::ContactSolution& solution = outcome.solution;
  Json steps = Json::array();
  for (const fem::ContactStep& step : solution.steps) steps.push_back(step_json(step, !outcome.on_patch()));
  Json out = {{"tactel", TACTEL_VERSION},
              {"scene", to_json(scene)},
              {"solver", outcome.solver},
              {"precision", outcome.precision},
              {"device", outcome.device},
              {"model", model_name(outcome)},
              {"model_reason", outcome.model_reason},
              {"surface_x", json_numbers(solution.surface_x)},
              {"surface_width", json_numbers(solution.surface_width)},
              {"base_x", outcome.on_patch() ? Json::array() : json_numbers(solution.base_x)},
              {"tactel_x", json_numbers(solution.tactel_x)},
              {"fallback", solution.fell_back},
              {"warnings", warnings(outcome)},
              {"steps", std::move(steps)}};
  if (!outcome.rung.empty()) out["rung"] = outcome.rung;
  if (outcome.plan) out["planner"] = to_json(*outcome.plan);
  if (outcome.derivatives) out["derivatives"] = derivatives_json(*outcome.derivatives);
  if (outcome.convergence) out["converge"] = to_json(*outcome.convergence);
  if (outcome.mesh_error) out["discretisation_error"] = mesh_error_json(*outcome.mesh_error);
  return out;
}

}  // namespace tactel::host
