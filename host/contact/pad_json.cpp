// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "fem/angles.h"
#include "host/contact/convergence.h"
#include "host/contact/json_values.h"

namespace tactel::host {
namespace {

using PadJson = nlohmann::ordered_json;

/// As a file has them: without what the way to radians and back leaves.

void add_pad_shape(PadJson& out, const fem::Sphere& s) { out["radius"] = s.radius; }
void add_pad_shape(PadJson& out, const fem::Paraboloid& s) { out["radii"] = s.radii; }
void add_pad_shape(PadJson& out, const fem::LyingCylinder& s) {
  out.update({{"radius", s.radius}, {"half_length", s.half_length}});
}
void add_pad_shape(PadJson& out, const fem::Punch& s) { out.update({{"radius", s.radius}, {"edge", s.edge}}); }
void add_pad_shape(PadJson& out, const fem::Box& s) { out.update({{"half_widths", s.half_widths}, {"edge", s.edge}}); }
void add_pad_shape(PadJson& out, const fem::Cone& s) { out["angle"] = s.angle; }
void add_pad_shape(PadJson& out, const fem::HeightMap& s) { out.update({{"file", s.file}, {"pitch", s.pitch}}); }

PadJson pad_indenter_json(const fem::PadIndenter& indenter) {
  PadJson out = {{"shape", fem::shape_name(indenter.shape)}};
  std::visit([&](const auto& shape) { add_pad_shape(out, shape); }, indenter.shape);
  out["position"] = indenter.position;
  out["yaw"] = indenter.yaw;
  if (std::holds_alternative<fem::Punch>(indenter.shape) || std::holds_alternative<fem::Box>(indenter.shape))
    out.update({{"tilt", indenter.tilt}, {"tilt_direction", indenter.tilt_direction}});
  return out;
}

PadJson pad_sensor_json(const fem::PadSensor& s) {
  PadJson out = {{"kind", "pad"},  {"tactels", s.tactels},     {"pitch", s.pitch}, {"tactel_size", s.tactel_size},
                 {"axes", s.axes}, {"thickness", s.thickness}, {"young", s.young}, {"poisson", s.poisson}};
  if (s.length) out["length"] = *s.length;
  if (s.width) out["width"] = *s.width;
  return out;
}

PadJson pad_load_json(const fem::PadLoad& load) {
  PadJson out;
  if (load.normal_force.empty())
    out["indentation"] = one_or_more(load.indentation);
  else
    out["normal_force"] = one_or_more(load.normal_force);
  out["indentation_steps"] = load.indentation_steps;
  for (const auto& [x, y, twist] : load.drags) {
    out["tangential"].push_back({x, y});
    out["twist"].push_back(fem::clean_degrees(twist));
  }
  return out;
}

template <class T>
PadJson or_null(const std::optional<T>& value) {
  return value ? PadJson(*value) : PadJson();
}

PadJson pad_step_json(const fem::PadStep& step, int axes) {
  PadJson traction = PadJson::array();
  for (Eigen::Index i = 0; i < step.tangential_force.rows(); ++i)
    traction.push_back({step.tangential_force(i, 0), step.tangential_force(i, 1)});
  PadJson out = {{"indentation", step.indentation},
                 {"tangential", {step.x, step.y}},
                 {"twist", fem::clean_degrees(step.twist)},
                 {"P", step.P},
                 {"Q", {step.Q[0], step.Q[1]}},
                 {"M", step.M},
                 {"slip_index", or_null(step.slip_index)},
                 {"force_ratio", or_null(step.force_ratio)},
                 {"stick_fraction", step.stick_fraction},
                 {"slip_distance", step.slip_distance},
                 {"sigma_z", json_numbers(step.stress.col(0))}};
  if (axes == 3) out.update({{"tau_x", json_numbers(step.stress.col(1))}, {"tau_y", json_numbers(step.stress.col(2))}});
  out.update({{"status", json_statuses(step.status)},
              {"normal_force", json_numbers(step.normal_force)},
              {"tangential_force", std::move(traction)},
              {"converged", step.converged},
              {"iterations", step.iterations},
              {"residual",
               {{"penetration", step.residual.penetration},
                {"complementarity", step.residual.complementarity},
                {"cone", step.residual.cone},
                {"drift", step.residual.drift},
                {"angle", step.residual.angle}}}});
  return out;
}

PadJson pad_error_json(const PadError& error) {
  const auto& e = error.most95;
  PadJson out = {{"slip_index", e.slip_index}, {"P", e.P},    {"Q", e.Q}, {"M", e.M},
                 {"sigma_z", e.sigma},         {"tau", e.tau}};
  out.update({{"largest", error.largest}, {"scenes", error.scenes}, {"outside", error.outside}});
  if (!error.from.empty()) out["from"] = error.from;
  return out;
}

}  // namespace

PadJson to_json(const fem::PadScene& scene) {
  return {{"title", scene.title},
          {"sensor", pad_sensor_json(scene.sensor)},
          {"indenter", pad_indenter_json(scene.indenter)},
          {"contact", {{"friction", scene.friction}}},
          {"load", pad_load_json(scene.load)}};
}

PadJson to_json(const PadOutcome& outcome) {
  const fem::PadSolution& solution = outcome.solution;
  const Eigen::MatrixX2d tactels = fem::tactel_places(outcome.scene.sensor);
  PadJson steps = PadJson::array();
  for (const fem::PadStep& step : solution.steps) steps.push_back(pad_step_json(step, outcome.scene.sensor.axes));
  PadJson out = {{"tactel", TACTEL_VERSION},
                 {"scene", to_json(outcome.scene)},
                 {"solver", outcome.solver},
                 {"precision", outcome.precision},
                 {"device", outcome.device},
                 {"model", model_name(outcome)},
                 {"rung", outcome.rung.name},
                 {"tactel_x", json_numbers(tactels.col(0))},
                 {"tactel_y", json_numbers(tactels.col(1))},
                 {"cell_x", json_numbers(solution.places.col(0))},
                 {"cell_y", json_numbers(solution.places.col(1))},
                 {"cell_width", {solution.cells.hx, solution.cells.hy}},
                 {"fallback", outcome.solution.fell_back},
                 {"warnings", warnings(outcome)},
                 {"steps", std::move(steps)}};
  if (outcome.error) out["discretisation_error"] = pad_error_json(*outcome.error);
  if (outcome.convergence) out["converge"] = to_json(*outcome.convergence);
  if (outcome.accuracy) out["accuracy"] = {{"asked", *outcome.accuracy}, {"kept", outcome.kept()}};
  return out;
}

}  // namespace tactel::host
