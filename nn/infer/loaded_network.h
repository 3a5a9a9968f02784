// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>

#include "nn/infer/layers.h"
#include "nn/infer/network_file.h"

namespace tactel::infer {

/// Returns a matrix [inputs, inputs] laid out for vectors: [tiles, inputs, tile], 0 beyond its columns.
std::vector<float> tiled(const std::vector<float>& whitening, std::size_t inputs);

/// What the bound takes from a scaled frame, before the layers overwrite it.
struct FrameClass {
  int touching = 0;    ///< tactels above 5 % of the largest normal stress
  float distance = 0;  ///< squared, as nn::squared_distance
};
/// `bound.whitening` as tiled() returns it.
FrameClass classify(const nn::Bound& bound, const float* scaled) noexcept;

}  // namespace tactel::infer

namespace tactel {

/// A network as SlipEstimator evaluates it.
struct SlipEstimator::Network {
  static SlipEstimator of(const nn::Model& model, infer::Metadata metadata);

  mutable std::atomic<std::size_t> owners = 1;
  std::vector<infer::HiddenLayer> hidden;
  std::vector<float> output;       ///< [outputs, inputs of the last layer + 1], the bias last
  int last = 0;                    ///< inputs of the last layer
  std::optional<nn::Bound> bound;  ///< its whitening as infer::tiled() returns it
  int inputs = 0;                  ///< stresses of an input, of all its frames
  int normals = 0;                 ///< normal stresses of the newest frame
  nn::InputScaling scaling;
  nn::InputHistory history;
  float factor = 0;
  nn::Learnt learnt;
  infer::Metadata metadata;
};

}  // namespace tactel
