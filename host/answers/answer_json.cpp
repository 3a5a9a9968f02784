// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <string_view>

#include "host/answers/answer_forms.h"
#include "host/answers/convergence.h"
#include "host/answers/step_quantities.h"
#include "host/answers/warnings.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

// A value of a quantity: numbers, null, words, lists of them, or residuals.
template <class Value>
Json json_of(const Value& value) {
  return value;
}
template <class Value>
Json json_of(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}
template <class Law>
requires requires(const Law& law) { residuals(law); }
Json json_of(const Law& law) {
  Json all;
  each(residuals(law), [&](const auto& residual) { all[residual.key] = residual.value; });
  return all;
}
template <class Matrix>
requires requires(const Matrix& of) { of.rowwise(); }
Json json_of(const Matrix& matrix) {
  Json all = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) row.push_back(matrix(i, k));
    all.push_back(matrix.cols() == 1 ? row.front() : std::move(row));
  }
  return all;
}
Json json_of(const fem::Degrees& angle) { return fem::clean_degrees(angle.radians); }
Json json_of(const std::vector<fem::GapStatus>& statuses) {
  Json words = Json::array();
  for (const fem::GapStatus status : statuses)
    words.push_back(status == fem::GapStatus::open ? "open" : status == fem::GapStatus::stick ? "stick" : "slip");
  return words;
}

/// Forces of the base are of a mesh alone, shear stresses of tactels with three axes.
template <class Step>
Json steps_json(const std::vector<Step>& steps, bool base, bool shear) {
  Json all = Json::array();
  for (const Step& step : steps)
    each(quantities<false>(step), [&, &json = all.emplace_back()](const auto& quantity) {
      const std::string_view key = quantity.key;
      if (OfPad<Step> && !shear && key.starts_with("tau")) return;
      Json value = !base && key.starts_with("base") ? Json::array() : json_of(quantity.value);
      if (std::string_view(quantity.extent).starts_with("markers") && value.empty()) return;  // none
      json[quantity.key] = std::move(value);
    });
  return all;
}

Json error_json(const ExpectedError& error, bool of_pad) {
  const AnswerError& e = error.expected;
  Json out = {{"slip_index", e.S}, {"P", e.P}, {"Q", e.Q}};
  if (of_pad) out["M"] = e.M;
  out[of_pad ? "sigma_z" : "sigma_y"] = e.sigma, out[of_pad ? "tau" : "tau_xy"] = e.tau;
  if (e.markers > 0) out["markers"] = e.markers;
  if (of_pad)
    out.update(
        {{"largest", error.largest}, {"strain", error.strain}, {"scenes", error.scenes}, {"outside", error.outside}});
  if (!error.from.empty()) out["from"] = error.from;
  return out;
}

/// What answers of both kinds begin with.
Json head(const auto& outcome) {
  return {{"tactel", TACTEL_VERSION},       {"scene", to_json(outcome.scene)}, {"solver", outcome.solver},
          {"precision", outcome.precision}, {"device", outcome.device},        {"model", model_name(outcome)}};
}

}  // namespace

Json to_json(const SolveOutcome& outcome) {
  const fem::ContactSolution& solution = outcome.solution;
  Json out = head(outcome);
  out.update({{"model_reason", outcome.model_reason},
              {"surface_x", json_of(solution.surface_x)},
              {"surface_width", json_of(solution.surface_width)},
              {"base_x", outcome.on_patch() ? Json::array() : json_of(solution.base_x)},
              {"tactel_x", json_of(solution.tactel_x)},
              {"fallback", solution.fell_back},
              {"warnings", warnings(outcome)},
              {"steps", steps_json(solution.steps, !outcome.on_patch(), true)}});
  if (!outcome.rung.name.empty()) out["rung"] = outcome.rung.name;
  if (outcome.plan) out["planner"] = to_json(*outcome.plan);
  if (outcome.convergence) out["converge"] = to_json(*outcome.convergence);
  if (outcome.error) out["discretisation_error"] = error_json(*outcome.error, false);
  return out;
}

Json to_json(const PadOutcome& outcome) {
  const fem::PadSolution& solution = outcome.solution;
  const Eigen::MatrixX2d tactels = fem::tactel_places(outcome.scene.sensor);
  Json out = head(outcome);
  out.update({{"rung", outcome.rung.name},
              {"tactel_x", json_of(tactels.col(0))},
              {"tactel_y", json_of(tactels.col(1))},
              {"cell_x", json_of(solution.places.col(0))},
              {"cell_y", json_of(solution.places.col(1))},
              {"cell_width", {solution.cells.hx, solution.cells.hy}},
              {"fallback", solution.fell_back},
              {"warnings", warnings(outcome)},
              {"steps", steps_json(solution.steps, true, outcome.scene.sensor.axes == 3)}});
  if (outcome.scene.friction_map) out["cell_friction"] = json_of(fem::friction_at(outcome.scene, solution.places));
  if (outcome.error) out["discretisation_error"] = error_json(*outcome.error, true);
  if (outcome.convergence) out["converge"] = to_json(*outcome.convergence);
  if (outcome.accuracy) out["accuracy"] = {{"asked", *outcome.accuracy}, {"kept", outcome.kept()}};
  return out;
}

}  // namespace tactel::host
