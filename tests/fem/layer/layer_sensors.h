// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>

#include "fem/layer/layer_model.h"
#include "fem/scenes/scene.h"

namespace tactel::fem {

/// The default sensor as part of an endless layer, one model for each Poisson's ratio.
inline const LayerModel& endless(double poisson) {
  static std::map<double, LayerModel> models;
  const auto found = models.find(poisson);
  if (found != models.end()) return found->second;
  const Sensor sensor{.poisson = poisson};
  return models.emplace(poisson, endless_layer(sensor)).first->second;
}

/// A layer so thick, 1500 mm, that a contact of 1 mm sees a half-plane; E = 2 MPa.
inline const LayerModel& half_plane(double poisson) {
  static std::map<double, LayerModel> models;
  const auto found = models.find(poisson);
  if (found != models.end()) return found->second;
  const Sensor sensor{.length = 20, .thickness = 1500, .poisson = poisson};
  return models.emplace(poisson, endless_layer(sensor)).first->second;
}

/// A scene on the model's sensor.
inline Scene scene_on(const LayerModel& model, const Shape& shape, double position, double mu, const Load& load) {
  return {"", model.sensor, {shape, position}, mu, load};
}

}  // namespace tactel::fem
