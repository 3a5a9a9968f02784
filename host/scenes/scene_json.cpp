// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/scene_json.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "fem/numbers/angles.h"
#include "fem/scenes/scene_numbers.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

using SceneJson = nlohmann::ordered_json;

template <class Value>
void put_value(SceneJson& out, const char* key, const Value& value) {
  out[key] = value;
}
void put_value(SceneJson& out, const char* key, fem::Element element) { out[key] = fem::name(element); }
void put_value(SceneJson& out, const char* key, fem::StressRecovery recovery) { out[key] = fem::name(recovery); }
void put_value(SceneJson& out, const char* key, fem::Sides sides) { out[key] = fem::name(sides); }
template <class Value>
void put_value(SceneJson& out, const char* key, const std::optional<Value>& value) {
  if (value) out[key] = *value;
}

template <class T>
void add_numbers(SceneJson& out, const T& from) {
  fem::each_number<T>([&](const auto& number) { put_value(out, number.key, from.*number.member); });
}

template <class S>
void add_shape(SceneJson& out, const S& shape) {
  add_numbers(out, shape);
}
void add_shape(SceneJson& out, const fem::Taylor& shape) {
  add_numbers(out, fem::with_height(shape));
  if (shape.coefficients.empty()) out.erase("coefficients");
}
void add_shape(SceneJson& out, const fem::Profile& shape) {
  if (!shape.file.empty()) out["file"] = shape.file;
  out.update({{"x", shape.x}, {"y", shape.y}, {"smooth", shape.smooth}});
}
void add_shape(SceneJson& out, const fem::HeightMap& shape) {
  out.update({{"file", shape.file}, {"pitch", shape.pitch}});
}

template <class Indenter>
SceneJson indenter_json(const Indenter& indenter) {
  SceneJson out = {{"shape", fem::shape_name(indenter.shape)}};
  std::visit([&](const auto& shape) { add_shape(out, shape); }, indenter.shape);
  add_numbers(out, indenter);
  if (!fem::tilts(indenter.shape)) out.erase("tilt"), out.erase("tilt_direction");
  if (!out.contains("young")) out.erase("poisson");  // rigid
  return out;
}

/// Layers in place of the numbers that they give.
void add_layers(SceneJson& out, const std::vector<RubberLayer>& layers) {
  for (const RubberLayer& layer : layers) add_numbers(out["layers"].emplace_back(), layer);
  if (layers.empty()) return;
  for (const char* key : {"thickness", "young", "poisson"}) out.erase(key);
}

SceneJson sensor_json(const fem::Scene& scene) {
  SceneJson out = {{"model", scene.model == fem::SurfaceModel::patch ? "patch" : "mesh"}};
  add_numbers(out, fem::with_span(scene.sensor));
  add_layers(out, scene.sensor.layers);
  return out;
}
SceneJson sensor_json(const fem::PadScene& scene) {
  SceneJson out = {{"kind", "pad"}};
  add_numbers(out, scene.sensor);
  add_layers(out, scene.sensor.layers);
  if (!scene.sensor.relaxation.empty()) out["relaxation"] = scene.sensor.relaxation;
  if (!scene.sensor.length || !scene.sensor.width) out.erase("sides");  // not known
  if (scene.sensor.depth == 0) out.erase("depth");
  return out;
}

/// A number alone, or an array.
SceneJson one_or_more(const std::vector<double>& values) {
  if (values.size() == 1) return values.front();
  return values;
}

template <class Load>
SceneJson pressing_json(const Load& load) {
  SceneJson out;
  if (load.normal_force.empty())
    out["indentation"] = one_or_more(load.indentation);
  else
    out["normal_force"] = one_or_more(load.normal_force);
  out["indentation_steps"] = load.indentation_steps;
  return out;
}

SceneJson load_json(const fem::Load& load) {
  SceneJson out = pressing_json(load);
  if (!load.tangential.empty()) out["tangential"] = load.tangential;
  if (load.tangential_step != 0.0) out["tangential_step"] = load.tangential_step;
  put_value(out, "tangential_steps", load.tangential_steps);
  for (const fem::LoadMove& move : load.moves) out["moves"].push_back(SceneJson::array({move.normal, move.tangential}));
  put_value(out, "angle", load.angle);
  return out;
}
SceneJson load_json(const fem::PadLoad& load) {
  SceneJson out = pressing_json(load);
  for (const auto& [x, y, twist] : load.drags) {
    out["tangential"].push_back({x, y});
    out["twist"].push_back(fem::clean_degrees(twist));
  }
  if (!load.times.empty()) out["times"] = load.times;
  return out;
}

template <class Scene>
SceneJson scene_json(const Scene& scene) {
  return {{"title", scene.title},
          {"sensor", sensor_json(scene)},
          {"indenter", indenter_json(scene.indenter)},
          {"contact", {{"friction", std::isinf(scene.friction) ? SceneJson("bonded") : SceneJson(scene.friction)}}},
          {"load", load_json(scene.load)}};
}

}  // namespace

SceneJson to_json(const fem::Scene& scene) { return scene_json(scene); }
SceneJson to_json(const fem::PadScene& scene) {
  SceneJson out = scene_json(scene);
  if (scene.markers) {
    add_numbers(out["markers"], *scene.markers);
    if (!scene.markers->places.empty())
      out["markers"].erase("counts"), out["markers"].erase("pitch"), out["markers"]["places"] = scene.markers->places;
  }
  if (scene.camera) add_numbers(out["camera"], *scene.camera);
  if (scene.camera && scene.camera->noise_px == 0) out["camera"].erase("noise_px");
  if (const auto& map = scene.friction_map)
    out["contact"] = {{"friction_map", map->rows}, {"friction_pitch", map->pitch}};
  return out;
}

namespace {

using Json = nlohmann::ordered_json;

/// A number, text, array or inline table; the texts of JSON are those of TOML.
std::string value_text(const Json& value) {
  if (value.is_number_float()) {
    const std::string text = fmt::format("{}", value.get<double>());
    return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
  }
  std::string text;
  if (value.is_object()) {
    for (const auto& [key, member] : value.items())
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key, value_text(member));
    return "{ " + text + " }";
  }
  if (!value.is_array()) return value.dump();
  for (const Json& element : value) text += (text.empty() ? "" : ", ") + value_text(element);
  return "[" + text + "]";
}

/// A profile's file has its points.
void leave_out_points(Json& indenter) {
  if (!indenter.contains("x") || !indenter.contains("y") || indenter["shape"] != "profile") return;
  if (!indenter.contains("file"))
    throw ConfigError("scene", "indenter.file", "(missing)", "given: points of a profile stand in a CSV file");
  indenter.erase("x"), indenter.erase("y");
}

/// A patch has no mesh: a file that names one asks for it.
void leave_out_mesh(Json& sensor) {
  if (sensor.value("model", "") != "patch") return;
  for (const char* key : {"columns", "rows", "grading", "element", "stress"}) sensor.erase(key);
}

std::string toml(Json scene) {
  leave_out_points(scene["indenter"]);
  leave_out_mesh(scene["sensor"]);
  std::string text;
  for (const auto& [key, value] : scene.items()) {
    if (!value.is_object()) {
      text += fmt::format("{} = {}\n", key, value_text(value));
      continue;
    }
    text += fmt::format("\n[{}]\n", key);
    for (const auto& [name, number] : value.items()) text += fmt::format("{} = {}\n", name, value_text(number));
  }
  return text;
}

}  // namespace

std::string scene_toml(const fem::Scene& scene) { return toml(to_json(scene)); }
std::string scene_toml(const fem::PadScene& scene) { return toml(to_json(scene)); }

}  // namespace tactel::host
