// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad.h>

#include <cmath>

#include "host/api/api_errors.h"
#include "host/api/scene_conversion.h"
#include "host/scenes/scene_file.h"
#include "host/support/errors.h"

namespace tactel {
namespace api {
namespace {

fem::Shape shape_to_fem(const Flat& s) { return fem::Flat{s.half_width}; }
fem::Shape shape_to_fem(const Wedge& s) { return fem::Wedge{s.edge_angle}; }
fem::Shape shape_to_fem(const Parabola& s) { return fem::Parabola{s.radius}; }
fem::Shape shape_to_fem(const Cylinder& s) { return fem::Cylinder{s.radius}; }
fem::Shape shape_to_fem(const Exponential& s) { return fem::Exponential{s.height, s.rate}; }
fem::Shape shape_to_fem(const Trapezoid& s) { return fem::Trapezoid{s.half_width, s.slope}; }
fem::Shape shape_to_fem(const RoundedFlat& s) { return fem::RoundedFlat{s.half_width, s.radius}; }
fem::Shape shape_to_fem(const Taylor& s) { return fem::Taylor{s.powers, s.scale, s.height, s.coefficients}; }
fem::Shape shape_to_fem(const Profile& s) { return fem::Profile{s.x, s.y, s.smooth, "points of the profile"}; }

Shape shape_from_fem(const fem::Flat& s) { return Flat{s.half_width}; }
Shape shape_from_fem(const fem::Wedge& s) { return Wedge{s.edge_angle}; }
Shape shape_from_fem(const fem::Parabola& s) { return Parabola{s.radius}; }
Shape shape_from_fem(const fem::Cylinder& s) { return Cylinder{s.radius}; }
Shape shape_from_fem(const fem::Exponential& s) { return Exponential{s.height, s.rate}; }
Shape shape_from_fem(const fem::Trapezoid& s) { return Trapezoid{s.half_width, s.slope}; }
Shape shape_from_fem(const fem::RoundedFlat& s) { return RoundedFlat{s.half_width, s.radius}; }
Shape shape_from_fem(const fem::Taylor& s) { return Taylor{s.powers, s.scale, s.height, s.coefficients}; }
Shape shape_from_fem(const fem::Profile& s) { return Profile{s.x, s.y, s.smooth}; }

static_assert(int(Element::bbar) == int(fem::Element::bbar) && int(Element::q8) == int(fem::Element::q8));
static_assert(int(Element::q4) == int(fem::Element::q4) && int(Element::q4i) == int(fem::Element::q4i));
static_assert(int(StressRecovery::reaction) == int(fem::StressRecovery::reaction));
static_assert(int(StressRecovery::element) == int(fem::StressRecovery::element));

fem::Sensor sensor_to_fem(const Sensor& from) {
  fem::Sensor sensor;
  sensor.length = from.length, sensor.thickness = from.thickness;
  sensor.young = from.young, sensor.poisson = from.poisson;
  sensor.tactels = from.tactels, sensor.tactel_span = from.tactel_span, sensor.tactel_width = from.tactel_width;
  if (from.mesh) {
    sensor.columns = from.mesh->columns, sensor.rows = from.mesh->rows, sensor.grading = from.mesh->grading;
    sensor.element = static_cast<fem::Element>(from.mesh->element);
    sensor.stress = static_cast<fem::StressRecovery>(from.mesh->stress);
  }
  return sensor;
}

Sensor sensor_from_fem(const fem::Sensor& from, fem::SurfaceModel model) {
  Sensor sensor;
  sensor.length = from.length, sensor.thickness = from.thickness;
  sensor.young = from.young, sensor.poisson = from.poisson;
  sensor.tactels = from.tactels, sensor.tactel_span = from.tactel_span, sensor.tactel_width = from.tactel_width;
  if (model == fem::SurfaceModel::mesh)
    sensor.mesh = Mesh{from.columns, from.rows, from.grading, static_cast<Element>(from.element),
                       static_cast<StressRecovery>(from.stress)};
  return sensor;
}

/// The members of a load have the same names on both sides.
template <class To, class From>
To load_as(const From& from) {
  To load;
  load.indentation = from.indentation, load.normal_force = from.normal_force;
  load.indentation_steps = from.indentation_steps;
  load.tangential = from.tangential, load.tangential_step = from.tangential_step;
  load.tangential_steps = from.tangential_steps, load.angle = from.angle;
  for (const auto& move : from.moves) load.moves.push_back({move.normal, move.tangential});
  return load;
}

}  // namespace

fem::Indenter to_fem(const Indenter& indenter) {
  return {std::visit([](const auto& shape) { return shape_to_fem(shape); }, indenter.shape), indenter.position};
}

fem::Scene to_fem(const Scene& scene) {
  fem::Scene made;
  made.title = scene.title;
  made.sensor = sensor_to_fem(scene.sensor);
  made.indenter = to_fem(scene.indenter);
  made.friction = scene.friction;
  made.load = load_as<fem::Load>(scene.load);
  made.model = scene.sensor.mesh ? fem::SurfaceModel::mesh : fem::SurfaceModel::patch;
  return made;
}

Scene from_fem(const fem::Scene& scene) {
  Scene made;
  made.title = scene.title;
  made.sensor = sensor_from_fem(scene.sensor, scene.model);
  made.indenter.shape = std::visit([](const auto& shape) { return shape_from_fem(shape); }, scene.indenter.shape);
  made.indenter.position = scene.indenter.position;
  made.friction = scene.friction;
  made.load = load_as<Load>(scene.load);
  return made;
}

void check_precision(const std::string& precision) {
  if (!precision.empty() && precision != "fp32" && precision != "fp64")
    throw ConfigError("command line", "--precision", precision, "fp32 or fp64");
}

host::SolveOptions to_host(const SolveOptions& from) {
  check_precision(from.precision);
  host::SolveOptions options;
  options.solver = from.solver, options.precision = from.precision, options.device = from.device;
  options.rung = from.rung, options.accuracy = from.accuracy, options.tolerance = from.tolerance;
  return options;
}

host::SolveOptions to_host_for_many(const SolveOptions& from) {
  if (from.solver != "batched") throw ConfigError("command line", "--solver", from.solver, "batched for many scenes");
  if (from.tolerance && !(std::isfinite(*from.tolerance) && *from.tolerance > 0))
    throw ConfigError("command line", "--tolerance", std::to_string(*from.tolerance), "a number above 0");
  return to_host(from);
}

namespace {

/// Returns the scene of a file of this kind. `other`: the kind that it must not be, `own`: what is allowed.
template <class Kind>
auto read_kind(const std::string& path, const char* other, const char* own) {
  return with_public_errors([&] {
    const host::AnyScene scene = host::read_any_scene(path);
    const Kind* one = std::get_if<Kind>(&scene);
    if (one == nullptr) throw ConfigError(path, "sensor.kind", other, own);
    return from_fem(*one);
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
void validate(const PadScene& scene) {
  api::with_public_errors([&] { api::to_fem(scene).validate(); });
}

std::vector<double> heights(const Indenter& indenter, const std::vector<double>& x) {
  const fem::Indenter profile = api::to_fem(indenter);
  api::with_public_errors([&] { profile.validate(); });
  const auto y =
      fem::profile_heights(profile, Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
  return {y.begin(), y.end()};
}

}  // namespace tactel
