// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <random>

#include "nn/frame_set.h"
#include "tests/host/device/test_device.h"

namespace tactel::tests {

using host::executor;

/// PoCL in the place of a GPU.
inline host::Executor& gpu() {
  static host::Executor posed(executor().device().as_gpu(), {.threads = 1});
  return posed;
}

/// Rows that look like frames: a bump of normal stress of random place, width and height (compression: negative), and
/// beneath it a shear bump that grows, skewed, with the slippage index. MPa. `inputs` is even.
inline nn::FrameSet bumps(int rows, int inputs, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  nn::FrameSet set{nn::RowMatrix<float>(rows, inputs), nn::Vector<float>(rows), {}, {}};
  const int tactels = inputs / 2;
  for (int row = 0; row < rows; ++row) {
    const float place = static_cast<float>(tactels) * (0.3f + 0.4f * uniform(random)),
                width = 1.0f + 3.0f * uniform(random);
    const float height = 0.2f + uniform(random), mu = 0.2f + uniform(random), s = uniform(random);
    for (int k = 0; k < tactels; ++k) {
      const float r = (static_cast<float>(k) - place) / width, bump = std::exp(-r * r);
      set.frames(row, k) = -height * bump;
      set.frames(row, tactels + k) = mu * s * height * bump * (1.0f + (1.0f - s) * r);
    }
    set.slip_index(row) = s;
  }
  return set;
}

template <class A, class B>
double largest_difference(const A& a, const B& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
    if (!(difference <= largest)) largest = difference;  // NaN stays
  }
  return largest;
}

}  // namespace tactel::tests
