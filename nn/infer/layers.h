// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "nn/infer/network_file.h"

namespace tactel::infer {

/// Neurons that are summed together: their sums stay in registers.
inline constexpr int tile = 32;

/// A hidden layer, laid out for vectors of neurons.
struct HiddenLayer {
  int inputs = 0, outputs = 0, tiles = 0;
  bool leaky = false;          ///< leaky rectifiers, else logistic neurons
  std::vector<float> weights;  ///< [tiles, inputs + 1, tile], the bias last; 0 beyond the outputs
};

HiddenLayer hidden_layer(const FileLayer& layer);

/// Outputs of a layer, or inputs of the first.
struct alignas(64) Activations {
  float values[widest_layer];
};

/// Computes o_j = f(sum_i w_ji x_i + b_j) of a hidden layer, f(z) = 1/2 tanh(z/2) or the leaky rectifier. The
/// arithmetic is that of kernels/shared/forward_layer.h, operation by operation: fused multiply-adds from the bias on,
/// in the order of the inputs, and the rational function of kernels/shared/activation.h. Every processor therefore
/// gives equal bits.
void hidden_outputs(const HiddenLayer& layer, const float* x, float* o) noexcept;

/// Returns f of the output neuron, in four sums: (0 + 1) + (2 + 3). weights: [inputs + 1], the bias last.
float output_neuron(const float* weights, int inputs, const float* x) noexcept;

}  // namespace tactel::infer
