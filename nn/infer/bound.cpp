// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "nn/infer/layers.h"
#include "nn/infer/loaded_network.h"

// Outside of namespace tactel, as in layers.cpp.
namespace {

using tactel::infer::tile;

/// |(scaled - centre) * whitening|^2, in the order of nn::squared_distance. whitening: [tiles, inputs, tile]. No
/// multiply-add is fused (CMakeLists.txt): the bits are those of every processor.
FOR_EACH_PROCESSOR float squared_distance(const float* whitening, const float* centre, int inputs,
                                          const float* scaled) noexcept {
  float sum = 0;
  for (int first = 0; first < inputs; first += tile) {
    float product[tile] = {};
    for (int j = 0; j < inputs; ++j, whitening += tile) {
      const float x = scaled[j] - centre[j];
      for (int i = 0; i < tile; ++i) product[i] += x * whitening[i];
    }
    for (int i = 0; i < tile; ++i) sum += product[i] * product[i];
  }
  return sum;
}

}  // namespace

namespace tactel::infer {
std::vector<float> tiled(const std::vector<float>& whitening, std::size_t inputs) {
  const std::size_t tiles = (inputs + tile - 1) / tile;
  std::vector<float> all(tiles * inputs * tile, 0.0f);
  for (std::size_t j = 0; j < inputs; ++j)
    for (std::size_t i = 0; i < inputs; ++i)
      all[((i / tile) * inputs + j) * tile + i % tile] = whitening[j * inputs + i];
  return all;
}

FrameClass classify(const nn::Bound& bound, const float* scaled) noexcept {
  const auto tactels = static_cast<std::size_t>(bound.tactels);
  float largest = 0;
  for (std::size_t k = 0; k < tactels; ++k) largest = std::max(largest, std::abs(scaled[k]));
  FrameClass frame;
  for (std::size_t k = 0; k < tactels; ++k) frame.touching += std::abs(scaled[k]) > nn::Bound::touching_share * largest;
  const int inputs = static_cast<int>(bound.centre.size());
  frame.distance = squared_distance(bound.whitening.data(), bound.centre.data(), inputs, scaled);
  if (std::isnan(frame.distance)) frame.distance = std::numeric_limits<float>::infinity();  // infinity less infinity
  return frame;
}

}  // namespace tactel::infer
