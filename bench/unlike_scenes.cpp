// SPDX-License-Identifier: Apache-2.0
#include "bench/unlike_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tactel::host {
namespace {

void scale_lengths(fem::Load& load, double factor) {
  for (auto* numbers : {&load.indentation, &load.tangential})
    for (double& number : *numbers) number *= factor;
}

/// A convex profile as a profilometer gives it: 3 to 30 points at uneven places, on 1 to 5 mm a side.
fem::Profile measured_profile(SceneDraw& draw) {
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
fem::Shape blunt_shape(std::size_t kind, double half_width, double depth, SceneDraw& draw) {
  const double slant = half_width * draw.uniform(0.2, 0.6), flat = half_width - slant;
  if (kind == 0) return fem::Flat{half_width};
  if (kind == 1) return fem::Wedge{180 - 2 * std::atan(depth / half_width) * 180 / std::numbers::pi};
  if (kind == 2) return fem::Parabola{half_width * half_width / (2 * depth)};
  if (kind == 3) return fem::Trapezoid{flat, depth / slant};
  if (kind == 4) return fem::RoundedFlat{flat, slant * slant / (2 * depth)};
  fem::Profile profile;
  profile.x = {-half_width, -0.6 * half_width, 0, slant, half_width};
  profile.y = {depth, 0.4 * depth, 0, 0.1 * depth, depth};
  return profile;
}

/// A contact of 5 to 60 thicknesses to a side on rubber of nu 0.49 to 0.5, dragged up to where it slides or so.
fem::Scene thin_scene(fem::Scene scene, std::size_t place, SceneDraw& draw) {
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
fem::Scene slippery_scene(fem::Scene scene, std::size_t place, SceneDraw& draw) {
  const double friction = draw.log_uniform(0.02, 0.1);
  for (double& x : scene.load.tangential) x *= friction / scene.friction;
  scene.friction = friction;
  if (place % 3 != 0) return scene;
  const double P = draw.log_uniform(0.02, 0.6);  // N/mm
  scene.load.indentation.clear();
  scene.load.normal_force = {P / 2, P};
  return scene;
}

fem::Scene changed(fem::Scene scene, std::size_t place, Unlike respect, SceneDraw draw) {
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
      scene.sensor.poisson = poisson[place / mix_kinds % poisson.size()];
      scene.indenter.position = std::copysign(draw.uniform(9, 10), scene.indenter.position);
      break;
    }
  }
  return scene;
}

}  // namespace

std::vector<fem::Scene> unlike_scenes(Unlike respect, std::uint64_t seed, std::size_t count) {
  std::vector<fem::Scene> scenes = mixed_scenes(seed, count);
  for (std::size_t place = 0; place < count; ++place)
    scenes[place] = changed(std::move(scenes[place]), place, respect,
                            SceneDraw(seed + 1 + static_cast<std::uint64_t>(respect), place));
  return scenes;
}

}  // namespace tactel::host
