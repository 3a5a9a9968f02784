// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <random>

#include "nn/frame_set.h"

namespace tactel::nn {

/// Uniform inputs from -1 to 1, and a smooth function of their sum as target.
inline TrainingSet<double> random_set(int rows, int inputs, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  TrainingSet<double> set{RowMatrix<double>(rows, inputs), Vector<double>(rows)};
  for (int row = 0; row < rows; ++row) {
    for (int k = 0; k < inputs; ++k) set.inputs(row, k) = uniform(random);
    set.target(row) = 0.4 * std::tanh(set.inputs.row(row).sum());
  }
  return set;
}

}  // namespace tactel::nn
