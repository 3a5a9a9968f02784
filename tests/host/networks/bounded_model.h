// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <random>

#include "nn/forward.h"
#include "nn/model.h"
#include "tests/host/networks/network_cases.h"

namespace tactel::tests {

/// A network with a bound whose tables differ from class to class, and whose limit of unlike frames divides `bumps`.
inline nn::Model bounded_model(const char* topology, nn::ScalingKind kind, bool by_distance = true) {
  nn::Weights<float> weights = nn::initial_weights(nn::Topology::parse(topology), 7);
  for (float& w : weights.values) w *= 3;  // S well away from 0.5
  const int inputs = weights.topology.inputs();
  nn::Model model{weights, {kind, 1.37f}, 7, 0.1, "bumps", 100, {1234, 0.31, 0.0123, 0.02}};
  model.bound =
      nn::uncalibrated_bound(nn::scale_frames<float>(model.scaling, bumps(2000, inputs, 5).frames), inputs / 2);
  nn::Bound& bound = *model.bound;
  bound.touching = {2.5f, 4.5f};
  bound.slip_index = {0.3f, 0.5f, 0.7f};
  bound.width = {0.8f, 1.0f};
  if (by_distance) bound.distance = {0.5f * static_cast<float>(inputs), 0.8f * static_cast<float>(inputs)};
  bound.upper_correction.resize(bound.classes());
  bound.interval_correction.resize(bound.classes());
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-0.4f, 0.1f);
  for (float& c : bound.upper_correction) c = uniform(random);
  for (float& c : bound.interval_correction) c = uniform(random);
  bound.unlike_above = static_cast<float>(inputs);
  bound.level = 0.9;
  bound.set = "other.h5", bound.rows = 4321, bound.seed = 77;
  return model;
}

/// The bound of every frame by the twin, from S and quantiles of its network: [rows].
inline std::vector<nn::BoundAnswer> bounds_of(const nn::Model& model, const nn::Recall<float>& answer,
                                              const nn::RowMatrix<float>& frames) {
  std::vector<nn::BoundAnswer> bounds;
  std::vector<float> scaled(static_cast<std::size_t>(frames.cols()));
  for (Eigen::Index row = 0; row < frames.rows(); ++row) {
    nn::scale_frame(model.scaling, frames.row(row).data(), static_cast<int>(scaled.size()), scaled.data());
    bounds.push_back(
        nn::bounded(*model.bound, {answer.slip_index(row), answer.upper(row), answer.lower(row)}, scaled.data()));
  }
  return bounds;
}

}  // namespace tactel::tests
