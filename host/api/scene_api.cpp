// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad.h>

#include <cmath>

#include "host/api/conversion.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/scene_json.h"
#include "host/support/errors.h"

namespace tactel {
namespace api {
namespace {

/// Rubber and tactels, which both structs have by the same names.
void copy_rubber(auto& to, const auto& from) {
  to.length = from.length, to.thickness = from.thickness, to.young = from.young, to.poisson = from.poisson;
  to.tactels = from.tactels, to.tactel_span = from.tactel_span, to.tactel_width = from.tactel_width;
  to.layers = from.layers;
}

fem::Sensor sensor_to_fem(const Sensor& from) {
  fem::Sensor sensor;
  copy_rubber(sensor, from);
  if (from.mesh) {
    sensor.columns = from.mesh->columns, sensor.rows = from.mesh->rows, sensor.grading = from.mesh->grading;
    sensor.element = from.mesh->element;
    sensor.stress = from.mesh->stress;
  }
  return with_layers(std::move(sensor));
}

Sensor sensor_from_fem(const fem::Sensor& from, fem::SurfaceModel model) {
  Sensor sensor;
  copy_rubber(sensor, from);
  if (model == fem::SurfaceModel::mesh)
    sensor.mesh = Mesh{from.columns, from.rows, from.grading, from.element, from.stress};
  return sensor;
}

}  // namespace

fem::Scene to_fem(const Scene& scene) {
  return {scene.title,    sensor_to_fem(scene.sensor),
          scene.indenter, scene.friction,
          scene.load,     scene.sensor.mesh ? fem::SurfaceModel::mesh : fem::SurfaceModel::patch};
}

Scene from_fem(const fem::Scene& scene) {
  return {scene.title, sensor_from_fem(scene.sensor, scene.model), scene.indenter, scene.friction, scene.load};
}

void check_precision(const std::string& precision) {
  if (!precision.empty() && precision != "fp32" && precision != "fp64")
    throw ConfigError("command line", "--precision", precision, "fp32 or fp64");
}

void check_for_many(const SolveOptions& options) {
  if (options.solver != "batched")
    throw ConfigError("command line", "--solver", options.solver, "batched for many scenes");
  if (options.tolerance && !(std::isfinite(*options.tolerance) && *options.tolerance > 0))
    throw ConfigError("command line", "--tolerance", std::to_string(*options.tolerance), "a number above 0");
  check_precision(options.precision);
}

namespace {

/// Returns the scene of a file of this kind. `other`: the kind that it must not be, `own`: what is allowed.
template <class Kind>
auto read_kind(const std::string& path, const char* other, const char* own) {
  return with_public_errors([&] {
    const host::AnyScene scene = host::read_any_scene(path);
    const Kind* read = std::get_if<Kind>(&scene);
    if (read == nullptr) throw ConfigError(path, "sensor.kind", other, own);
    return from_fem(*read);
  });
}

}  // namespace
}  // namespace api

Scene read_scene(const std::string& path) {
  return api::read_kind<fem::Scene>(path, "\"pad\"", "\"line\", or read by read_pad_scene");
}

PadScene read_pad_scene(const std::string& path) {
  return api::read_kind<fem::PadScene>(path, "\"line\"", "\"pad\", or read by read_scene");
}

std::variant<Scene, PadScene> read_any_scene(const std::string& path) {
  using Any = std::variant<Scene, PadScene>;
  return api::with_public_errors([&] {
    return std::visit([](const auto& scene) { return Any(api::from_fem(scene)); }, host::read_any_scene(path));
  });
}

void validate(const Scene& scene) {
  api::with_public_errors([&] { api::to_fem(scene).validate(); });
}
std::string toml(const Scene& scene) {
  return api::with_public_errors([&] { return host::scene_toml(api::to_fem(scene)); });
}
std::string toml(const PadScene& scene) {
  return api::with_public_errors([&] { return host::scene_toml(api::to_fem(scene)); });
}
void validate(const PadScene& scene) {
  api::with_public_errors([&] { api::to_fem(scene).validate(); });
}

std::vector<double> heights(const Indenter& indenter, const std::vector<double>& x) {
  api::with_public_errors([&] { fem::validate(indenter); });
  const auto y =
      fem::profile_heights(indenter, Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
  return {y.begin(), y.end()};
}

}  // namespace tactel
