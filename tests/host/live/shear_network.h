// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>

#include "nn/model.h"

namespace tactel {

/// S = 1 / (1 + exp(-10 shear)) of the shear of tactel 0 along the first axis, above 0, in MPa; of two tactels.
inline nn::Model shear_network(int axes = 2, int frames = 1) {
  nn::Weights<float> weights =
      nn::initial_weights(nn::Topology({2 * axes * frames, 1, 1}, nn::Activation::leaky_relu), 7);
  std::ranges::fill(weights.values, 0.0f);
  weights.values[2] = 1;                           // the first shear
  weights.values[weights.values.size() - 2] = 10;  // behind the hidden neuron, in front of the last bias
  nn::Model model{weights, {nn::ScalingKind::set, 1.0f, frames, axes}, 7, 0, "", 0, {}};
  model.history.frames = frames;
  return model;
}

/// A network of two tactels that takes friction: S = 1 / (1 + exp(10 mu / (mu + 0.5) - 8)). S = 0.97 where the logit is
/// 3.476, x = mu / (mu + 0.5) = 0.4524: mu = 0.5 x / (1 - x) = 0.413.
inline nn::Model friction_network() {
  nn::Weights<float> weights = nn::initial_weights(nn::Topology({6, 1, 1}, nn::Activation::leaky_relu), 7);
  std::ranges::fill(weights.values, 0.0f);
  weights.values[4] = 1, weights.values[weights.values.size() - 2] = -10, weights.values.back() = 8;
  nn::Model model{weights, {.friction = true}, 7, 0, "", 0, {}};
  model.history.friction = true;
  model.learnt = {.least_friction = 0.2f, .most_friction = 1.2f};
  return model;
}

/// The shear of an S.
inline float shear_of(float s) { return std::log(s / (1 - s)) / 10; }

}  // namespace tactel
