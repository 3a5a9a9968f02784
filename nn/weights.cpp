// SPDX-License-Identifier: Apache-2.0
#include "nn/weights.h"

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
  return weights;
}

}  // namespace tactel::nn
