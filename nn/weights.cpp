// SPDX-License-Identifier: Apache-2.0
#include "nn/weights.h"

#include <cmath>

#include "nn/philox.h"

namespace tactel::nn {

Weights<float> initial_weights(const Topology& topology, std::uint64_t seed) {
  Weights<float> weights(topology);
  PhiloxCounter words{};
  for (std::uint32_t i = 0; i < weights.values.size(); ++i) {
    if (i % 4 == 0) words = random_words(seed, RandomStream::weights, i / 4);
    // The upper 24 bits as the middle of one of 2^24 cells of (-1, 1): exact in float.
    const float cell = static_cast<float>(static_cast<std::int32_t>(words[i % 4] >> 8) - (1 << 23)) + 0.5f;
    weights.values[i] = cell * 0x1p-23f * initial_weight_bound;
  }
  if (topology.hidden_activation() == Activation::logistic) return weights;
  for (int l = 0; l < topology.layers(); ++l) {
    const float variance = (l + 1 < topology.layers() ? 2.0f : 1.0f) / static_cast<float>(topology.fan_in(l));
    weights.layer(l) *= std::sqrt(3 * variance) / initial_weight_bound;  // uniform in +-b: a variance of b^2 / 3
    weights.layer(l).rightCols(1).setZero();
  }
  return weights;
}

}  // namespace tactel::nn
