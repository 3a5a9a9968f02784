// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/scene_toml.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/scenes/scene_json.h"
#include "host/support/errors.h"

namespace tactel::host {
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
    for (const auto& [key, one] : value.items())
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key, value_text(one));
    return "{ " + text + " }";
  }
  if (!value.is_array()) return value.dump();
  for (const Json& one : value) text += (text.empty() ? "" : ", ") + value_text(one);
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
    for (const auto& [name, one] : value.items()) text += fmt::format("{} = {}\n", name, value_text(one));
  }
  return text;
}

}  // namespace

std::string scene_toml(const fem::Scene& scene) { return toml(to_json(scene)); }
std::string scene_toml(const fem::PadScene& scene) { return toml(to_json(scene)); }

}  // namespace tactel::host
