// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/distributed_keys.h"

#include <algorithm>

#include "host/scenes/scene_tables.h"

namespace tactel::host {
namespace {

template <class Scene>
struct Entry {
  std::string shape;  ///< empty: any
  std::string key;
  NumberPlace<Scene> place;
};

template <class Shape, class Scene>
Shape& as(Scene& scene) {
  return std::get<Shape>(scene.indenter.shape);
}

using S = fem::Scene;
using P = fem::PadScene;

const std::vector<Entry<S>>& entries(const S*) {
  static const std::vector<Entry<S>> all = {
      {"", "sensor.length", [](S& s, int, double v) { s.sensor.length = v; }},
      {"", "sensor.thickness", [](S& s, int, double v) { s.sensor.thickness = v; }},
      {"", "sensor.young", [](S& s, int, double v) { s.sensor.young = v; }},
      {"", "sensor.poisson", [](S& s, int, double v) { s.sensor.poisson = v; }},
      {"", "sensor.grading", [](S& s, int, double v) { s.sensor.grading = v; }},
      {"", "sensor.tactel_span", [](S& s, int, double v) { s.sensor.tactel_span.value() = v; }},
      {"", "sensor.tactel_width", [](S& s, int, double v) { s.sensor.tactel_width = v; }},
      {"", "indenter.position", [](S& s, int, double v) { s.indenter.position = v; }},
      {"flat", "indenter.half_width", [](S& s, int, double v) { as<fem::Flat>(s).half_width.value() = v; }},
      {"wedge", "indenter.edge_angle", [](S& s, int, double v) { as<fem::Wedge>(s).edge_angle = v; }},
      {"parabola", "indenter.radius", [](S& s, int, double v) { as<fem::Parabola>(s).radius = v; }},
      {"cylinder", "indenter.radius", [](S& s, int, double v) { as<fem::Cylinder>(s).radius = v; }},
      {"exponential", "indenter.height", [](S& s, int, double v) { as<fem::Exponential>(s).height = v; }},
      {"exponential", "indenter.rate", [](S& s, int, double v) { as<fem::Exponential>(s).rate = v; }},
      {"trapezoid", "indenter.half_width", [](S& s, int, double v) { as<fem::Trapezoid>(s).half_width = v; }},
      {"trapezoid", "indenter.slope", [](S& s, int, double v) { as<fem::Trapezoid>(s).slope = v; }},
      {"rounded_flat", "indenter.half_width", [](S& s, int, double v) { as<fem::RoundedFlat>(s).half_width = v; }},
      {"rounded_flat", "indenter.radius", [](S& s, int, double v) { as<fem::RoundedFlat>(s).radius = v; }},
      {"taylor", "indenter.scale", [](S& s, int, double v) { as<fem::Taylor>(s).scale = v; }},
      {"taylor", "indenter.height", [](S& s, int, double v) { as<fem::Taylor>(s).height.value() = v; }},
      {"taylor", "indenter.coefficients", [](S& s, int i, double v) { as<fem::Taylor>(s).coefficients[i] = v; }},
      {"", "contact.friction", [](S& s, int, double v) { s.friction = v; }},
      {"", "load.indentation", [](S& s, int i, double v) { s.load.indentation[i] = v; }},
      {"", "load.normal_force", [](S& s, int i, double v) { s.load.normal_force[i] = v; }},
      {"", "load.tangential", [](S& s, int i, double v) { s.load.tangential[i] = v; }},
      {"", "load.tangential_step", [](S& s, int, double v) { s.load.tangential_step = v; }},
      {"", "load.angle", [](S& s, int, double v) { s.load.angle.value() = v; }},
  };
  return all;
}

/// One of equal steps: positions are its multiples.
void put_step(P& scene, int axis, double step) {
  for (std::size_t k = 0; k < scene.load.drags.size(); ++k)
    scene.load.drags[k][axis] = static_cast<double>(k + 1) * step;
}

const std::vector<Entry<P>>& entries(const P*) {
  static const std::vector<Entry<P>> all = {
      {"", "sensor.thickness", [](P& s, int, double v) { s.sensor.thickness = v; }},
      {"", "sensor.young", [](P& s, int, double v) { s.sensor.young = v; }},
      {"", "sensor.poisson", [](P& s, int, double v) { s.sensor.poisson = v; }},
      {"", "indenter.position", [](P& s, int i, double v) { s.indenter.position[i] = v; }},
      {"", "indenter.yaw", [](P& s, int, double v) { s.indenter.yaw = v; }},
      {"punch", "indenter.tilt", [](P& s, int, double v) { s.indenter.tilt = v; }},
      {"punch", "indenter.tilt_direction", [](P& s, int, double v) { s.indenter.tilt_direction = v; }},
      {"box", "indenter.tilt", [](P& s, int, double v) { s.indenter.tilt = v; }},
      {"box", "indenter.tilt_direction", [](P& s, int, double v) { s.indenter.tilt_direction = v; }},
      {"sphere", "indenter.radius", [](P& s, int, double v) { as<fem::Sphere>(s).radius = v; }},
      {"paraboloid", "indenter.radii", [](P& s, int i, double v) { as<fem::Paraboloid>(s).radii[i] = v; }},
      {"cylinder", "indenter.radius", [](P& s, int, double v) { as<fem::LyingCylinder>(s).radius = v; }},
      {"cylinder", "indenter.half_length", [](P& s, int, double v) { as<fem::LyingCylinder>(s).half_length = v; }},
      {"punch", "indenter.radius", [](P& s, int, double v) { as<fem::Punch>(s).radius = v; }},
      {"punch", "indenter.edge", [](P& s, int, double v) { as<fem::Punch>(s).edge = v; }},
      {"box", "indenter.half_widths", [](P& s, int i, double v) { as<fem::Box>(s).half_widths[i] = v; }},
      {"box", "indenter.edge", [](P& s, int, double v) { as<fem::Box>(s).edge = v; }},
      {"cone", "indenter.angle", [](P& s, int, double v) { as<fem::Cone>(s).angle = v; }},
      {"", "contact.friction", [](P& s, int, double v) { s.friction = v; }},
      {"", "load.indentation", [](P& s, int i, double v) { s.load.indentation[i] = v; }},
      {"", "load.normal_force", [](P& s, int i, double v) { s.load.normal_force[i] = v; }},
      {"", "load.tangential", [](P& s, int i, double v) { s.load.drags[i / 2][i % 2] = v; }},
      {"", "load.tangential_step", put_step},
      {"", "load.twist", [](P& s, int i, double v) { s.load.drags[i][2] = radians(v); }},
      {"", "load.twist_step", [](P& s, int, double v) { put_step(s, 2, radians(v)); }},
  };
  return all;
}

template <class Scene>
bool fits(const Entry<Scene>& entry, const std::string& shape) {
  return entry.shape.empty() || entry.shape == shape;
}

}  // namespace

template <class Scene>
NumberPlace<Scene> number_place(const std::string& key, const std::string& shape) {
  const std::vector<Entry<Scene>>& all = entries(static_cast<const Scene*>(nullptr));
  const auto found = std::ranges::find_if(all, [&](const auto& e) { return e.key == key && fits(e, shape); });
  return found == all.end() ? nullptr : found->place;
}

template <class Scene>
std::vector<std::string> drawable_keys(const std::string& table, const std::string& shape) {
  std::vector<std::string> keys;
  for (const Entry<Scene>& entry : entries(static_cast<const Scene*>(nullptr)))
    if (entry.key.starts_with(table + ".") && fits(entry, shape)) keys.push_back(entry.key.substr(table.size() + 1));
  return keys;
}

template NumberPlace<S> number_place(const std::string&, const std::string&);
template NumberPlace<P> number_place(const std::string&, const std::string&);
template std::vector<std::string> drawable_keys<S>(const std::string&, const std::string&);
template std::vector<std::string> drawable_keys<P>(const std::string&, const std::string&);

}  // namespace tactel::host
