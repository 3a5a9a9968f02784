// SPDX-License-Identifier: Apache-2.0
#include "host/contact/scene_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/contact/json_values.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

void add_shape(Json& out, const fem::Flat& s) {
  if (s.half_width) out["half_width"] = *s.half_width;
}
void add_shape(Json& out, const fem::Wedge& s) { out["edge_angle"] = s.edge_angle; }
void add_shape(Json& out, const fem::Parabola& s) { out["radius"] = s.radius; }
void add_shape(Json& out, const fem::Cylinder& s) { out["radius"] = s.radius; }
void add_shape(Json& out, const fem::Exponential& s) { out.update({{"height", s.height}, {"rate", s.rate}}); }
void add_shape(Json& out, const fem::Trapezoid& s) { out.update({{"half_width", s.half_width}, {"slope", s.slope}}); }
void add_shape(Json& out, const fem::RoundedFlat& s) {
  out.update({{"half_width", s.half_width}, {"radius", s.radius}});
}
void add_shape(Json& out, const fem::Taylor& s) {
  out.update({{"powers", s.powers}, {"scale", s.scale}, {"height", s.height.value_or(s.scale)}});
  if (!s.coefficients.empty()) out["coefficients"] = s.coefficients;
}
void add_shape(Json& out, const fem::Profile& s) {
  if (!s.file.empty()) out["file"] = s.file;
  out.update({{"x", s.x}, {"y", s.y}, {"smooth", s.smooth}});
}

Json indenter_json(const fem::Indenter& indenter) {
  Json out = {{"shape", fem::shape_name(indenter.shape)}};
  std::visit([&](const auto& shape) { add_shape(out, shape); }, indenter.shape);
  out["position"] = indenter.position;
  return out;
}

Json sensor_json(const fem::Sensor& s, fem::SurfaceModel model) {
  return {{"model", model == fem::SurfaceModel::patch ? "patch" : "mesh"},
          {"length", s.length},
          {"thickness", s.thickness},
          {"young", s.young},
          {"poisson", s.poisson},
          {"columns", s.columns},
          {"rows", s.rows},
          {"grading", s.grading},
          {"element", fem::name(s.element)},
          {"tactels", s.tactels},
          {"tactel_span", s.span()},
          {"tactel_width", s.tactel_width},
          {"stress", fem::name(s.stress)}};
}

Json load_json(const fem::Load& load) {
  Json out;
  if (load.normal_force.empty()) {
    out["indentation"] = one_or_more(load.indentation);
  } else {
    out["normal_force"] = one_or_more(load.normal_force);
  }
  out["indentation_steps"] = load.indentation_steps;
  if (!load.tangential.empty()) out["tangential"] = load.tangential;
  if (load.tangential_step != 0.0) out["tangential_step"] = load.tangential_step;
  if (load.tangential_steps) out["tangential_steps"] = *load.tangential_steps;
  for (const fem::LoadMove& move : load.moves) out["moves"].push_back(Json::array({move.normal, move.tangential}));
  if (load.angle) out["angle"] = *load.angle;
  return out;
}

}  // namespace

Json to_json(const fem::Scene& scene) {
  return {{"title", scene.title},
          {"sensor", sensor_json(scene.sensor, scene.model)},
          {"indenter", indenter_json(scene.indenter)},
          {"contact", {{"friction", std::isinf(scene.friction) ? Json("bonded") : Json(scene.friction)}}},
          {"load", load_json(scene.load)}};
}

}  // namespace tactel::host
