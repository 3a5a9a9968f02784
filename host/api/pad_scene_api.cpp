// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad.h>

#include <cmath>

#include "fem/numbers/angles.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "host/api/conversion.h"

namespace tactel::api {
namespace {

template <class S>
fem::PadShape pad_shape_to_fem(const S& shape) {
  return shape;
}
fem::PadShape pad_shape_to_fem(const HeightMap& s) {
  const std::size_t rows = s.columns > 0 ? s.heights.size() / s.columns : 0;
  if (rows < 2 || s.columns < 2 || rows * s.columns != s.heights.size())
    throw ValueError("indenter.heights", std::to_string(s.heights.size()) + " heights",
                     "a grid of 2 x 2 heights at least, with as many in each row");
  // Columns of Eigen's matrix are rows of the grid: both have x fastest.
  fem::HeightMap map{s.pitch, Eigen::Map<const Eigen::MatrixXd>(s.heights.data(), static_cast<Eigen::Index>(s.columns),
                                                                static_cast<Eigen::Index>(rows))};
  map.heights.array() -= map.heights.minCoeff();
  return map;
}

template <class S>
PadShape pad_shape_from_fem(const S& shape) {
  return shape;
}
PadShape pad_shape_from_fem(const fem::HeightMap& s) {
  return HeightMap{
      s.pitch, static_cast<std::size_t>(s.heights.rows()), {s.heights.data(), s.heights.data() + s.heights.size()}};
}

/// Returns degrees that radians() turns into exactly these radians, so that a file's twist survives reading; those of
/// few decimals where they do.
double degrees(double from) {
  const double near = fem::degrees(from);
  for (const double candidate : {std::round(near * 1e10) / 1e10, std::nextafter(near, -1e9), std::nextafter(near, 1e9)})
    if (fem::radians(candidate) == from) return candidate;
  return near;
}

}  // namespace

fem::PadScene to_fem(const PadScene& scene) {
  fem::PadScene made;
  made.title = scene.title;
  made.sensor = with_layers(scene.sensor);
  const PadIndenter& indenter = scene.indenter;
  made.indenter = {std::visit([](const auto& shape) { return pad_shape_to_fem(shape); }, indenter.shape),
                   indenter.position, indenter.yaw, indenter.tilt, indenter.tilt_direction};
  made.indenter.young = indenter.young, made.indenter.poisson = indenter.poisson;
  made.friction = scene.friction;
  if (scene.friction_map) {
    made.set_friction(*scene.friction_map);
    if (scene.friction != PadScene{}.friction)
      throw ValueError("contact.friction", fem::number_text(scene.friction), "left out beside contact.friction_map");
  }
  const PadLoad& load = scene.load;
  if (!load.twist.empty() && load.twist.size() != load.tangential.size())
    throw ValueError(
        "load.twist", std::to_string(load.twist.size()) + " twists",
        "as many as load.tangential has positions, " + std::to_string(load.tangential.size()) + ", or empty");
  made.load.indentation = load.indentation, made.load.normal_force = load.normal_force;
  made.load.indentation_steps = load.indentation_steps;
  for (std::size_t k = 0; k < load.tangential.size(); ++k)
    made.load.drags.push_back(
        {load.tangential[k][0], load.tangential[k][1], load.twist.empty() ? 0 : fem::radians(load.twist[k])});
  for (const auto& [normal, at, twist] : load.moves)
    made.load.moves.push_back({normal, at[0], at[1], fem::radians(twist)});
  made.load.times = load.times;
  made.markers = scene.markers, made.camera = scene.camera;
  return made;
}

PadScene from_fem(const fem::PadScene& scene) {
  PadScene made;
  made.title = scene.title;
  made.sensor = scene.sensor;
  const fem::PadIndenter& indenter = scene.indenter;
  made.indenter = {std::visit([](const auto& shape) { return pad_shape_from_fem(shape); }, indenter.shape),
                   indenter.position, indenter.yaw, indenter.tilt, indenter.tilt_direction};
  made.indenter.young = indenter.young, made.indenter.poisson = indenter.poisson;
  made.friction_map = scene.friction_map;
  if (!made.friction_map) made.friction = scene.friction;
  const fem::PadLoad& load = scene.load;
  made.load = {load.indentation, load.normal_force, load.indentation_steps};
  for (const auto& [x, y, twist] : load.drags) {
    made.load.tangential.push_back({x, y});
    made.load.twist.push_back(degrees(twist));
  }
  for (const auto& [normal, x, y, twist] : load.moves) made.load.moves.push_back({normal, {x, y}, degrees(twist)});
  made.load.times = load.times;
  made.markers = scene.markers, made.camera = scene.camera;
  return made;
}

}  // namespace tactel::api
