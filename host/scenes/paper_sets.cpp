// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/paper_sets.h"

#include <fmt/format.h>

#include "host/scenes/scene_file.h"

namespace tactel::host {
namespace {

void add(SceneFamily& family, const fem::Scene& base, const fem::Shape& shape, std::uint16_t kind) {
  fem::Scene scene = base;
  scene.indenter.shape = shape;
  scene.validate();
  family.scenes.push_back(std::move(scene));
  family.kind.push_back(kind);
}

std::string sum_of_powers(const std::vector<int>& powers) {
  if (powers.empty()) return "0";
  std::string text;
  for (int k : powers) text += fmt::format("{}x{}", text.empty() ? "" : " + ", k == 1 ? "" : fmt::format("^{}", k));
  return text;
}

}  // namespace

SceneFamily paper_learning_family(const fem::Scene& base, double scale, double height) {
  SceneFamily family;
  for (unsigned subset = 0; subset < 32; ++subset) {
    std::vector<int> powers;
    for (int k = 1; k <= 5; ++k)
      if (subset >> (k - 1) & 1u) powers.push_back(k);
    family.kind_names.push_back(sum_of_powers(powers));
    add(family, base, fem::Taylor{powers, scale, height}, static_cast<std::uint16_t>(subset));
  }
  return family;
}

SceneFamily paper_recall_family(const fem::Scene& base) {
  SceneFamily family;
  family.kind_names = {"flat",        "triangular",           "parabolic", "spherical", "exponential",
                       "trapezoidal", "flat, parabolic edges"};
  for (double half_width : {2.0, 3.0, 4.0, 5.0}) add(family, base, fem::Flat{half_width}, 0);
  for (double edge_angle : {120.0, 140.0, 160.0, 170.0}) add(family, base, fem::Wedge{edge_angle}, 1);
  for (double radius : {5.0, 10.0, 20.0, 40.0}) add(family, base, fem::Parabola{radius}, 2);
  for (double radius : {7.0, 15.0, 30.0, 60.0}) add(family, base, fem::Cylinder{radius}, 3);
  for (double rate : {0.25, 0.5, 1.0, 2.0}) add(family, base, fem::Exponential{0.1, rate}, 4);
  for (double half_width : {1.0, 2.0, 3.0, 4.0}) add(family, base, fem::Trapezoid{half_width, 0.5}, 5);
  for (double half_width : {1.0, 2.0, 3.0, 4.0}) add(family, base, fem::RoundedFlat{half_width, 10.0}, 6);
  return family;
}

fem::Scene paper_set_scene() {
  fem::Scene scene = paper_preset();
  scene.load.tangential_step = 0.05;
  scene.load.tangential_steps.reset();
  return scene;
}

SceneSource source_of(const SceneFamily& family) { return {family.scenes, family.kind, family.kind_names}; }

}  // namespace tactel::host
