// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "fem/angles.h"
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

}  // namespace

PadJson to_json(const fem::PadScene& scene) {
  return {{"title", scene.title},
          {"sensor", pad_sensor_json(scene.sensor)},
          {"indenter", pad_indenter_json(scene.indenter)},
          {"contact", {{"friction", scene.friction}}},
          {"load", pad_load_json(scene.load)}};
}

}  // namespace tactel::host
