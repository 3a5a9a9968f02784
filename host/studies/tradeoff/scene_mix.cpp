// SPDX-License-Identifier: Apache-2.0
#include "host/studies/tradeoff/scene_mix.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace tactel::host {
namespace {

/// Numbers that are the same wherever the program was built, unlike those of std::uniform_real_distribution.
class Draw {
 public:
  Draw(std::uint64_t seed, std::size_t place) : random_(seed * 1000003 + place) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }

 private:
  std::mt19937_64 random_;
};

constexpr std::size_t kinds = 8;

fem::Shape shape(std::size_t kind, Draw& draw) {
  switch (kind) {
    case 0:
      return fem::Flat{draw.uniform(1, 4)};
    case 1:
      return fem::Wedge{draw.uniform(140, 176)};
    case 2:
      return fem::Parabola{draw.log_uniform(2, 100)};
    case 3:
      return fem::Cylinder{draw.log_uniform(3, 100)};
    case 4:
      return fem::Exponential{0.1, draw.log_uniform(0.25, 2)};
    case 5:
      return fem::Trapezoid{draw.uniform(0.5, 4), draw.log_uniform(0.1, 1)};
    case 6:
      return fem::RoundedFlat{draw.uniform(0.5, 4), draw.log_uniform(3, 30)};
    default:
      return fem::Taylor{{1 + static_cast<int>(draw.uniform(0, 2)), 3, 5}, 10.0, draw.log_uniform(0.5, 4)};
  }
}

/// Eight positions: straight on, or (one scene in four) five there and three back. 4 mu depth is about where a parabola
/// slides.
std::vector<double> drag(double friction, double depth, bool back, Draw& draw) {
  const double end = friction * depth * draw.uniform(1, 5);
  std::vector<double> positions;
  for (int k = 1; k <= 8; ++k) positions.push_back(end * (back ? (k <= 5 ? k / 5.0 : 1 - (k - 5) / 4.0) : k / 8.0));
  return positions;
}

fem::Scene mixed_scene(std::uint64_t seed, std::size_t place) {
  constexpr std::array poisson = {0.45, 0.3, 0.49, 0.499};
  Draw draw(seed, place);
  fem::Scene scene;
  scene.sensor.poisson = poisson[place / kinds % poisson.size()];
  scene.indenter.shape = shape(place % kinds, draw);
  scene.indenter.position = draw.uniform(-4, 4);
  scene.friction = draw.log_uniform(0.1, 1.5);
  const double depth = draw.log_uniform(0.05, 0.3);
  scene.load.indentation = {depth};
  scene.load.tangential = drag(scene.friction, depth, draw.uniform(0, 1) < 0.25, draw);
  scene.title = fmt::format("scene {} of seed {}", place, seed);
  return scene;
}

void scale_lengths(fem::Load& load, double factor) {
  for (auto* numbers : {&load.indentation, &load.tangential})
    for (double& number : *numbers) number *= factor;
}

/// A convex profile as a profilometer gives it: 3 to 30 points at uneven places, on 1 to 5 mm a side.
fem::Profile measured_profile(Draw& draw) {
  const int pieces = static_cast<int>(draw.uniform(2, 30));
  const double half_width = draw.uniform(1, 5), height = draw.log_uniform(0.1, 1);
  std::vector<double> slopes, x = {-half_width};
  for (int k = 0; k < pieces; ++k) {
    slopes.push_back(draw.uniform(-1, 1));
    x.push_back(x.back() + draw.uniform(0.2, 1.8) * 2 * half_width / pieces);
  }
  std::ranges::sort(slopes);
  fem::Profile profile;
  profile.x = std::move(x);
  profile.y = {0};
  for (int k = 0; k < pieces; ++k)
    profile.y.push_back(profile.y.back() + slopes[k] * (profile.x[k + 1] - profile.x[k]));
  const auto [least, most] = std::ranges::minmax(profile.y);
  for (double& y : profile.y) y = height * (y - least) / (most - least);
  const double lowest = profile.x[std::ranges::min_element(profile.y) - profile.y.begin()];
  for (double& place : profile.x) place -= lowest;
  profile.smooth = 1e-9 * height;  // rounding must not count as a dent
  return profile;
}

/// A blunt indenter that reaches `half_width` to a side at `depth`.
fem::Shape blunt_shape(std::size_t kind, double half_width, double depth, Draw& draw) {
  const double slant = half_width * draw.uniform(0.2, 0.6), flat = half_width - slant;
  switch (kind) {
    case 0:
      return fem::Flat{half_width};
    case 1:
      return fem::Wedge{180 - 2 * std::atan(depth / half_width) * 180 / std::numbers::pi};
    case 2:
      return fem::Parabola{half_width * half_width / (2 * depth)};
    case 3:
      return fem::Trapezoid{flat, depth / slant};
    case 4:
      return fem::RoundedFlat{flat, slant * slant / (2 * depth)};
    default: {
      fem::Profile profile;
      profile.x = {-half_width, -0.6 * half_width, 0, slant, half_width};
      profile.y = {depth, 0.4 * depth, 0, 0.1 * depth, depth};
      return profile;
    }
  }
}

/// A contact of 5 to 60 thicknesses to a side on rubber of nu 0.49 to 0.5, dragged up to where it slides or so.
fem::Scene thin_scene(fem::Scene scene, std::size_t place, Draw& draw) {
  scene.model = fem::SurfaceModel::patch;  // a mesh takes no nu of 0.5
  fem::Sensor& s = scene.sensor;
  const double ratio = draw.log_uniform(5, 60), depth = draw.log_uniform(0.02, 0.2);  // over the thickness
  s.thickness = draw.log_uniform(0.2, 1.5);
  s.length = 3 * ratio * s.thickness;
  s.tactel_span = 2 * ratio * s.thickness;
  s.poisson = 0.5 - (place % 4 == 0 ? 0 : draw.log_uniform(1e-5, 1e-2));
  scene.indenter.shape = blunt_shape(place % 6, ratio * s.thickness, depth * s.thickness, draw);
  scene.indenter.position = draw.uniform(-0.05, 0.05) * s.length;
  scene.load.indentation = {depth * s.thickness};
  // Mean pressure over E, of the oedometer and of Reynolds' equation together; the shear that it brings about slides.
  const double nu = s.poisson, soft = (1 + nu) * (1 - 2 * nu) / (1 - nu) + 2 * (1 + nu) * 5 / (3 * ratio * ratio);
  const double end = scene.friction * depth / soft * 2 * (1 + nu) * s.thickness * draw.uniform(0.2, 1.3);
  for (std::size_t k = 0; k < scene.load.tangential.size(); ++k)
    scene.load.tangential[k] = end * static_cast<double>(k + 1) / static_cast<double>(scene.load.tangential.size());
  return scene;
}

/// The friction of fingers in oil. One scene in three is pressed with a force, in two parts.
fem::Scene slippery_scene(fem::Scene scene, std::size_t place, Draw& draw) {
  const double friction = draw.log_uniform(0.02, 0.1);
  for (double& x : scene.load.tangential) x *= friction / scene.friction;
  scene.friction = friction;
  if (place % 3 != 0) return scene;
  const double P = draw.log_uniform(0.02, 0.6);  // N/mm
  scene.load.indentation.clear();
  scene.load.normal_force = {P / 2, P};
  return scene;
}

fem::Scene changed(fem::Scene scene, std::size_t place, Unlike respect, Draw draw) {
  switch (respect) {
    case Unlike::thickness: {
      const double factor = draw.log_uniform(0.5, 4) / scene.sensor.thickness;
      scene.sensor.thickness *= factor;
      scale_lengths(scene.load, factor);
      break;
    }
    case Unlike::length:
      scene.sensor.length = draw.log_uniform(8, 60);
      scene.indenter.position *= scene.sensor.length / fem::Sensor{}.length;
      break;
    case Unlike::poisson:
      scene.sensor.poisson = 0.5 - draw.log_uniform(1e-4, 0.5);
      break;
    case Unlike::tactels:
      scene.sensor.tactels = static_cast<int>(draw.uniform(4, 65));
      scene.sensor.tactel_width = draw.uniform(0, std::min(0.5, 8.0 / scene.sensor.tactels));
      scene.sensor.tactel_span = draw.uniform(8, 19);
      break;
    case Unlike::force:
      scene.load.indentation.clear();
      scene.load.normal_force = {draw.log_uniform(0.01, 0.6)};  // N/mm
      break;
    case Unlike::profile:
      scene.indenter.shape = measured_profile(draw);
      break;
    case Unlike::ends:
      scene.indenter.position = std::copysign(draw.uniform(7, 9.9), scene.indenter.position);
      break;
    case Unlike::thin:
      return thin_scene(std::move(scene), place, draw);
    case Unlike::slippery:
      return slippery_scene(std::move(scene), place, draw);
    case Unlike::over_end: {
      constexpr std::array poisson = {0.0, 0.2, 0.3, 0.4, 0.45, 0.48};
      scene.sensor.poisson = poisson[place / kinds % poisson.size()];
      scene.indenter.position = std::copysign(draw.uniform(9, 10), scene.indenter.position);
      break;
    }
  }
  return scene;
}

}  // namespace

const char* description(Unlike respect) {
  switch (respect) {
    case Unlike::thickness:
      return "rubber 0.5 to 4 mm thick";
    case Unlike::length:
      return "sensors 8 to 60 mm long";
    case Unlike::poisson:
      return "nu from 0 to 0.4999";
    case Unlike::tactels:
      return "4 to 64 tactels, up to 0.5 mm wide";
    case Unlike::force:
      return "given forces, 0.01 to 0.6 N/mm";
    case Unlike::profile:
      return "measured profiles of 3 to 30 points";
    case Unlike::ends:
      return "indenters 0.1 to 3 mm from an end";
    case Unlike::thin:
      return "5 to 60 thicknesses to a side, nu 0.49 to 0.5";
    case Unlike::slippery:
      return "mu 0.02 to 0.1";
    case Unlike::over_end:
      return "over an end, nu 0 to 0.48";
  }
  return "";
}

std::vector<fem::Scene> unlike_scenes(Unlike respect, std::uint64_t seed, std::size_t count) {
  std::vector<fem::Scene> scenes = mixed_scenes(seed, count);
  for (std::size_t place = 0; place < count; ++place)
    scenes[place] =
        changed(std::move(scenes[place]), place, respect, Draw(seed + 1 + static_cast<std::uint64_t>(respect), place));
  return scenes;
}

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
      count, seed, kinds);
}

}  // namespace tactel::host
