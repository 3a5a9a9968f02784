// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/distributed_keys.h"

#include <algorithm>

namespace tactel::host {
namespace {

struct Entry {
  std::string shape;  ///< empty: any
  std::string key;
  NumberPlace place;
};

template <class Shape>
Shape& as(fem::Scene& scene) {
  return std::get<Shape>(scene.indenter.shape);
}

using S = fem::Scene;

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = {
      {"", "sensor.length", [](S& s, int) -> double& { return s.sensor.length; }},
      {"", "sensor.thickness", [](S& s, int) -> double& { return s.sensor.thickness; }},
      {"", "sensor.young", [](S& s, int) -> double& { return s.sensor.young; }},
      {"", "sensor.poisson", [](S& s, int) -> double& { return s.sensor.poisson; }},
      {"", "sensor.grading", [](S& s, int) -> double& { return s.sensor.grading; }},
      {"", "sensor.tactel_span", [](S& s, int) -> double& { return s.sensor.tactel_span.value(); }},
      {"", "sensor.tactel_width", [](S& s, int) -> double& { return s.sensor.tactel_width; }},
      {"", "indenter.position", [](S& s, int) -> double& { return s.indenter.position; }},
      {"flat", "indenter.half_width", [](S& s, int) -> double& { return as<fem::Flat>(s).half_width.value(); }},
      {"wedge", "indenter.edge_angle", [](S& s, int) -> double& { return as<fem::Wedge>(s).edge_angle; }},
      {"parabola", "indenter.radius", [](S& s, int) -> double& { return as<fem::Parabola>(s).radius; }},
      {"cylinder", "indenter.radius", [](S& s, int) -> double& { return as<fem::Cylinder>(s).radius; }},
      {"exponential", "indenter.height", [](S& s, int) -> double& { return as<fem::Exponential>(s).height; }},
      {"exponential", "indenter.rate", [](S& s, int) -> double& { return as<fem::Exponential>(s).rate; }},
      {"trapezoid", "indenter.half_width", [](S& s, int) -> double& { return as<fem::Trapezoid>(s).half_width; }},
      {"trapezoid", "indenter.slope", [](S& s, int) -> double& { return as<fem::Trapezoid>(s).slope; }},
      {"rounded_flat", "indenter.half_width", [](S& s, int) -> double& { return as<fem::RoundedFlat>(s).half_width; }},
      {"rounded_flat", "indenter.radius", [](S& s, int) -> double& { return as<fem::RoundedFlat>(s).radius; }},
      {"taylor", "indenter.scale", [](S& s, int) -> double& { return as<fem::Taylor>(s).scale; }},
      {"taylor", "indenter.height", [](S& s, int) -> double& { return as<fem::Taylor>(s).height.value(); }},
      {"taylor", "indenter.coefficients", [](S& s, int i) -> double& { return as<fem::Taylor>(s).coefficients[i]; }},
      {"", "contact.friction", [](S& s, int) -> double& { return s.friction; }},
      {"", "load.indentation", [](S& s, int i) -> double& { return s.load.indentation[i]; }},
      {"", "load.normal_force", [](S& s, int i) -> double& { return s.load.normal_force[i]; }},
      {"", "load.tangential", [](S& s, int i) -> double& { return s.load.tangential[i]; }},
      {"", "load.tangential_step", [](S& s, int) -> double& { return s.load.tangential_step; }},
      {"", "load.angle", [](S& s, int) -> double& { return s.load.angle.value(); }},
  };
  return all;
}

bool fits(const Entry& entry, const std::string& shape) { return entry.shape.empty() || entry.shape == shape; }

}  // namespace

NumberPlace number_place(const std::string& key, const std::string& shape) {
  const auto found = std::ranges::find_if(entries(), [&](const Entry& e) { return e.key == key && fits(e, shape); });
  return found == entries().end() ? nullptr : found->place;
}

std::vector<std::string> drawable_keys(const std::string& table, const std::string& shape) {
  std::vector<std::string> keys;
  for (const Entry& entry : entries())
    if (entry.key.starts_with(table + ".") && fits(entry, shape)) keys.push_back(entry.key.substr(table.size() + 1));
  return keys;
}

}  // namespace tactel::host
