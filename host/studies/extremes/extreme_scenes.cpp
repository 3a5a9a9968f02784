// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "host/studies/extremes/extremes.h"

namespace tactel::host {
namespace {

using Change = std::function<void(fem::Scene&)>;

/// Depth `depth` mm under a parabola that is 4 mm wide there, dragged in proportion.
void press(fem::Scene& scene, double depth) {
  scene.indenter.shape = fem::Parabola{4.0 / (2 * depth)};
  scene.load.indentation = {depth};
  scene.load.tangential.clear();
  for (double share : {0.3, 0.6, 1.2, 0.6, -0.6}) scene.load.tangential.push_back(share * depth);
}

void press_by_force(fem::Scene& scene, std::vector<double> forces) {
  scene.load.indentation.clear();
  scene.load.normal_force = std::move(forces);
  scene.load.tangential.clear();
}

/// A sphere that is pressed in, dragged until it nearly slides, along a turn, with a twist, and back.
fem::PadScene ordinary_pad() {
  fem::PadScene scene;
  scene.sensor.tactels = {2, 2}, scene.sensor.pitch = {7, 7};
  scene.load.drags = {{0.03, 0, 0}, {0.06, 0.03, 0}, {0.06, 0.06, 0.02}, {-0.06, 0, 0}};
  return scene;
}

class List {
 public:
  /// Scenes of lines from here on are solved on patches.
  void on_patches() { model_ = fem::SurfaceModel::patch; }
  void add(const std::string& group, const std::string& name, const Change& change) {
    fem::Scene scene = ordinary_scene();
    scene.model = model_;
    change(scene);
    scenes_.push_back({group, name, std::move(scene)});
  }
  void add_pad(const std::string& group, const std::string& name, const std::function<void(fem::PadScene&)>& change) {
    fem::PadScene scene = ordinary_pad();
    change(scene);
    scenes_.push_back({group, name, std::move(scene)});
  }
  std::vector<ExtremeScene> take() { return std::move(scenes_); }

 private:
  fem::SurfaceModel model_ = fem::SurfaceModel::mesh;
  std::vector<ExtremeScene> scenes_;
};

void add_material(List& list) {
  for (double nu : {0.0, 0.3, 0.45, 0.49, 0.4999, 0.49999})
    list.add("Poisson's ratio", fmt::format("{}", nu), [=](fem::Scene& s) { s.sensor.poisson = nu; });
  for (double young : {1e-6, 2.0, 1e6})
    list.add("E, MPa", fmt::format("{:g}", young), [=](fem::Scene& s) { s.sensor.young = young; });
}

void add_friction(List& list) {
  for (double mu : {0.0, 1e-6, 0.1, 1.0, 10.0, 100.0})
    list.add("friction", fmt::format("{:g}", mu), [=](fem::Scene& s) { s.friction = mu; });
  list.add("friction", "bonded", [](fem::Scene& s) { s.friction = std::numeric_limits<double>::infinity(); });
  list.add("friction", "S in 0.99 ... 1", [](fem::Scene& s) {
    s.load.tangential = {0.2, 0.2525, 0.255, 0.2575, 0.26, 0.2625, 0.265, 0.27, 0.28, 0.3};
  });
}

void add_size(List& list) {
  for (double depth : {1e-9, 1e-6, 1e-3})
    list.add("depth, mm", fmt::format("{:g}", depth), [=](fem::Scene& s) {
      s.load.indentation = {depth};
      for (double& x : s.load.tangential) x *= depth / 0.15;
    });
  for (double share : {0.1, 0.2, 0.5, 0.9})
    list.add("depth", fmt::format("{:g} % of thickness", 100 * share),
             [=](fem::Scene& s) { press(s, share * s.sensor.thickness); });
  for (double share : {0.01, 0.1, 1.0, 10.0})
    list.add("thickness/length", fmt::format("{:g}", share), [=](fem::Scene& s) {
      s.sensor.thickness = share * s.sensor.length;
      press(s, 0.05 * s.sensor.thickness);
    });
  list.add("size", "of a grain, 20 um", [](fem::Scene& s) {
    s.sensor.length *= 1e-3, s.sensor.thickness *= 1e-3;
    s.indenter.shape = fem::Parabola{0.01};
    s.load.indentation = {1.5e-4};
    for (double& x : s.load.tangential) x *= 1e-3;
  });
}

void add_mesh(List& list, bool finest) {
  for (double grading : {1.0, 4.0, 100.0})
    list.add("grading", fmt::format("{:g}", grading), [=](fem::Scene& s) { s.sensor.grading = grading; });
  for (auto [columns, rows] : {std::pair(3, 2), {5, 3}, {41, 11}, {123, 33}, {401, 101}}) {
    if (columns > 123 && !finest) continue;
    list.add("mesh", fmt::format("{} x {}", columns, rows), [columns = columns, rows = rows](fem::Scene& s) {
      s.sensor.columns = columns;
      s.sensor.rows = rows;
    });
  }
  for (auto element : {fem::Element::q4, fem::Element::q4i, fem::Element::q8})
    list.add("element, nu 0.4999", fem::name(element), [=](fem::Scene& s) {
      s.sensor.element = element;
      s.sensor.poisson = 0.4999;
    });
}

void add_contact(List& list) {
  list.add("contact", "one node", [](fem::Scene& s) { s.indenter.shape = fem::Wedge{20}; });
  list.add("contact", "one node, off the node", [](fem::Scene& s) { s.indenter = {fem::Wedge{120}, 0.2}; });
  list.add("contact", "between two nodes", [](fem::Scene& s) { s.indenter = {fem::Wedge{120}, 0.25}; });
  list.add("contact", "all nodes", [](fem::Scene& s) { s.indenter.shape = fem::Flat{}; });
  // Nodes stand 0.5 mm apart: the second one lies exactly on the indenter when that has come down.
  list.add("contact", "grazing", [](fem::Scene& s) {
    s.indenter.shape = fem::Parabola{1.0};
    s.load.indentation = {0.125};
  });
  list.add("contact", "not reached", [](fem::Scene& s) { s.indenter = {fem::Wedge{10}, 0.25}; });
  list.add("contact", "half off the sensor", [](fem::Scene& s) { s.indenter.position = s.sensor.length / 2; });
  list.add("contact", "slides off the sensor", [](fem::Scene& s) {
    s.indenter.position = s.sensor.length / 2 - 1;
    s.load.tangential = {0.5, 1, 2};
  });
}

void add_shapes(List& list) {
  for (double angle : {0.1, 20.0, 179.0})
    list.add("contact", fmt::format("wedge of {:g} degrees", angle),
             [=](fem::Scene& s) { s.indenter.shape = fem::Wedge{angle}; });
  for (double width : {1e-3, 1.0, 8.0})
    list.add("contact", fmt::format("flat, {:g} mm to a side", width),
             [=](fem::Scene& s) { s.indenter.shape = fem::Flat{width}; });
  list.add("contact", "all of the surface", [](fem::Scene& s) { s.indenter.shape = fem::Flat{}; });
  list.add("contact", "half off the sensor", [](fem::Scene& s) { s.indenter.position = s.sensor.length / 2; });
}

void add_loads(List& list) {
  list.add("load", "depth 0", [](fem::Scene& s) { s.load.indentation = {0.0}; });
  list.add("load", "in, out, in again", [](fem::Scene& s) { s.load.indentation = {0.15, 0.0, 0.15}; });
  list.add("load", "P = 0", [](fem::Scene& s) { press_by_force(s, {0.0}); });
  list.add("load", "P = 1, 0, 0.5 N/mm", [](fem::Scene& s) {
    press_by_force(s, {1.0, 0.0, 0.5});
    s.load.tangential = {0.1};
  });
  for (double P : {1e-9, 1e-3, 10.0})
    list.add("P, N/mm", fmt::format("{:g}", P), [=](fem::Scene& s) { press_by_force(s, {P}); });
  for (double share : {0.0, 0.5, 0.9, 0.98, 0.999})
    list.add("angle/limit", fmt::format("{:g}", share), [=](fem::Scene& s) {
      press_by_force(s, {0.5});
      s.load.angle = share * std::atan(s.friction) * 45 / std::atan(1.0);
    });
}

void press(fem::PadScene& scene, double depth) {
  for (auto& [x, y, twist] : scene.load.drags) x *= depth / 0.2, y *= depth / 0.2, twist *= depth / 0.2;
  scene.load.indentation = {depth};
}

void add_pads(List& list) {
  for (double nu : {0.0, 0.3, 0.45, 0.49, 0.4999, 0.5})
    list.add_pad("Poisson's ratio", fmt::format("{}", nu), [=](fem::PadScene& s) { s.sensor.poisson = nu; });
  for (double young : {1e-6, 1e6})
    list.add_pad("E, MPa", fmt::format("{:g}", young), [=](fem::PadScene& s) { s.sensor.young = young; });
  for (double mu : {0.0, 1e-6, 0.1, 1.0, 10.0, 100.0})
    list.add_pad("friction", fmt::format("{:g}", mu), [=](fem::PadScene& s) { s.friction = mu; });
  for (double depth : {1e-9, 1e-6, 1e-3})
    list.add_pad("depth, mm", fmt::format("{:g}", depth), [=](fem::PadScene& s) { press(s, depth); });
  for (double share : {0.2, 0.5, 0.9})
    list.add_pad("depth", fmt::format("{:g} % of thickness", 100 * share),
                 [=](fem::PadScene& s) { press(s, share * s.sensor.thickness); });
  for (double size : {1e-2, 0.1, 1.0, 10.0}) {
    list.add_pad("radius/thickness", fmt::format("{:g}, punch", size), [=](fem::PadScene& s) {
      s.indenter.shape = fem::Punch{size * s.sensor.thickness};
      press(s, 0.02 * std::min(size, 1.0));
    });
    list.add_pad("radius/thickness", fmt::format("{:g}, nu 1/2", size), [=](fem::PadScene& s) {
      s.sensor.poisson = 0.5;
      s.indenter.shape = fem::Punch{size * s.sensor.thickness, 0.5 * size};
      press(s, 0.02 * std::min(size, 1.0));
    });
  }
  list.add_pad("size", "of a grain, 20 um", [](fem::PadScene& s) {
    s.sensor.thickness *= 1e-3, s.sensor.pitch = {1e-3, 1e-3};
    s.indenter.shape = fem::Sphere{8e-3};
    press(s, 2e-4);
  });
  for (double angle : {20.0, 89.0})
    list.add_pad("contact", fmt::format("cone of {:g} degrees", angle),
                 [=](fem::PadScene& s) { s.indenter.shape = fem::Cone{angle}; });
  list.add_pad("contact", "20 times as long as wide", [](fem::PadScene& s) {
    s.indenter.shape = fem::Paraboloid{{0.1, 40}};
  });
  list.add_pad("contact", "measured pyramid", [](fem::PadScene& s) {
    const Eigen::ArrayXd far = Eigen::ArrayXd::LinSpaced(21, -10, 10).abs() / 10;
    s.indenter.shape = fem::HeightMap{0.2, (far.replicate(1, 21) + far.transpose().replicate(21, 1)).matrix()};
  });
  list.add_pad("contact", "sharp box", [](fem::PadScene& s) { s.indenter.shape = fem::Box{}; });
  list.add_pad("contact", "box on its edge", [](fem::PadScene& s) {
    s.indenter.shape = fem::Box{{2, 2}, 0.2};
    s.indenter.tilt = 10;
  });
  list.add_pad("contact", "cylinder, 8 by 0.1 mm", [](fem::PadScene& s) {
    s.indenter.shape = fem::LyingCylinder{0.1, 4};
  });
  list.add_pad("contact", "half beside the tactels", [](fem::PadScene& s) { s.indenter.position = {3.5, 0}; });
  list.add_pad("load", "depth 0", [](fem::PadScene& s) { s.load.indentation = {0}; });
  list.add_pad("load", "in, out, in again", [](fem::PadScene& s) { s.load.indentation = {0.2, 0, 0.2}; });
  for (double P : {0.0, 1e-9, 1e-3, 10.0})
    list.add_pad("P, N", fmt::format("{:g}", P), [=](fem::PadScene& s) {
      s.load.indentation.clear();
      s.load.normal_force = {P};
    });
  list.add_pad("load", "twist by 90 degrees", [](fem::PadScene& s) { s.load.drags = {{0, 0, std::numbers::pi / 2}}; });
  list.add_pad("load", "drag by 8 mm", [](fem::PadScene& s) { s.load.drags = {{8, 0, 0}, {0, 0, 0}}; });
}

}  // namespace

fem::Scene ordinary_scene() {
  fem::Scene scene;
  scene.indenter.shape = fem::Parabola{10.0};
  scene.load.tangential = {0.05, 0.1, 0.2, 0.1, -0.1};
  return scene;
}

std::vector<ExtremeScene> extreme_scenes(bool finest) {
  List list;
  add_material(list);
  add_friction(list);
  add_size(list);
  add_mesh(list, finest);
  add_contact(list);
  add_loads(list);
  list.on_patches();
  add_material(list);
  add_friction(list);
  add_size(list);
  add_shapes(list);
  add_loads(list);
  add_pads(list);
  return list.take();
}

}  // namespace tactel::host
