// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include "nn/infer/network_file.h"

namespace tactel::infer {

/// Quantiles of S from the outputs of the three heads, as nn::quantiles.
struct Quantiles {
  float median, upper, lower;
};

/// Returns a matrix [inputs, inputs] laid out for vectors: [tiles, inputs, tile], 0 beyond its columns.
std::vector<float> tiled(const std::vector<float>& whitening, std::size_t inputs);

/// What the bound takes from a scaled frame, before the layers overwrite it.
struct FrameClass {
  int touching = 0;     ///< tactels above 5 % of the largest normal stress
  float distance = 0;   ///< squared, as nn::squared_distance
  bool unlike = false;  ///< the frame is unlike those of the learning set
};
/// `bound.whitening` as tiled() returns it.
FrameClass classify(const FileBound& bound, const float* scaled) noexcept;

/// Fills in the bound of an answer, as nn::bounded.
void add_bound(const FileBound& bound, const FrameClass& frame, const Quantiles& quantiles, Answer& answer) noexcept;

}  // namespace tactel::infer
