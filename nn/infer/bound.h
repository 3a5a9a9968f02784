// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "nn/network.h"

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
