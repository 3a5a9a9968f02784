// SPDX-License-Identifier: Apache-2.0
#include "host/studies/tradeoff/scene_mix.h"

#include <fmt/format.h>

#include <array>

namespace tactel::host {
namespace {

fem::Shape shape(std::size_t kind, SceneDraw& draw) {
  if (kind == 0) return fem::Flat{draw.uniform(1, 4)};
  if (kind == 1) return fem::Wedge{draw.uniform(140, 176)};
  if (kind == 2) return fem::Parabola{draw.log_uniform(2, 100)};
  if (kind == 3) return fem::Cylinder{draw.log_uniform(3, 100)};
  if (kind == 4) return fem::Exponential{0.1, draw.log_uniform(0.25, 2)};
  if (kind == 5) return fem::Trapezoid{draw.uniform(0.5, 4), draw.log_uniform(0.1, 1)};
  if (kind == 6) return fem::RoundedFlat{draw.uniform(0.5, 4), draw.log_uniform(3, 30)};
  return fem::Taylor{{1 + static_cast<int>(draw.uniform(0, 2)), 3, 5}, 10.0, draw.log_uniform(0.5, 4)};
}

/// Eight positions: straight on, or (one scene in four) five there and three back. 4 mu depth is about where a parabola
/// slides.
std::vector<double> drag(double friction, double depth, bool back, SceneDraw& draw) {
  const double end = friction * depth * draw.uniform(1, 5);
  std::vector<double> positions;
  for (int k = 1; k <= 8; ++k) positions.push_back(end * (back ? (k <= 5 ? k / 5.0 : 1 - (k - 5) / 4.0) : k / 8.0));
  return positions;
}

fem::Scene mixed_scene(std::uint64_t seed, std::size_t place) {
  constexpr std::array poisson = {0.45, 0.3, 0.49, 0.499};
  SceneDraw draw(seed, place);
  fem::Scene scene;
  scene.sensor.poisson = poisson[place / mix_kinds % poisson.size()];
  scene.indenter.shape = shape(place % mix_kinds, draw);
  scene.indenter.position = draw.uniform(-4, 4);
  scene.friction = draw.log_uniform(0.1, 1.5);
  const double depth = draw.log_uniform(0.05, 0.3);
  scene.load.indentation = {depth};
  scene.load.tangential = drag(scene.friction, depth, draw.uniform(0, 1) < 0.25, draw);
  scene.title = fmt::format("scene {} of seed {}", place, seed);
  return scene;
}

}  // namespace

std::vector<fem::Scene> mixed_scenes(std::uint64_t seed, std::size_t count) {
  std::vector<fem::Scene> scenes;
  for (std::size_t place = 0; place < count; ++place) scenes.push_back(mixed_scene(seed, place));
  return scenes;
}

std::string mix_description(std::uint64_t seed, std::size_t count) {
  return fmt::format(
      "{} contacts drawn with seed {}: {} shapes in turn, -4 to 4 mm off centre, nu 0.3, 0.45, 0.49 or 0.499, mu 0.1 "
      "to "
      "1.5, 0.05 to 0.3 mm deep, eight drags, reversed in one scene of four",
      count, seed, mix_kinds);
}

}  // namespace tactel::host
