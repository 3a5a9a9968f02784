// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "nn/network.h"

// Fused multiply-adds are instructions of every x86 processor since 2013; elsewhere libm computes the same bits.
// Vectors of 16 numbers halve the time. The variant is chosen when the library is loaded. Sanitizers do not go with
// that.
#if defined(__x86_64__) && !defined(__FMA__) && !defined(TACTEL_SANITIZED)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("default", "fma", "avx512f")))
#else
#define FOR_EACH_PROCESSOR
#endif

namespace tactel::infer {

/// Neurons that are summed together: their sums stay in registers.
inline constexpr int tile = 32;

/// A hidden layer, laid out for vectors of neurons.
struct HiddenLayer {
  int inputs = 0, outputs = 0, tiles = 0;
  bool leaky = false;          ///< leaky rectifiers, else logistic neurons
  std::vector<float> weights;  ///< [tiles, inputs + 1, tile], the bias last; 0 beyond the outputs
};

/// Layer l of a network.
HiddenLayer hidden_layer(const nn::Weights<float>& weights, int l);

inline constexpr int widest_layer = nn::Topology::widest_layer;

/// Frames that are evaluated together: a weight that is loaded serves all of them.
inline constexpr int most_frames = 4;

/// Outputs of a layer, or inputs of the first, frame by frame.
struct alignas(64) Activations {
  float values[most_frames][widest_layer];
};

/// Computes o_j = f(sum_i w_ji x_i + b_j) of a hidden layer, f(z) = 1/2 tanh(z/2) or the leaky rectifier, for one
/// frame, or for all most_frames. The arithmetic is that of kernels/shared/forward_layer.h, operation by operation:
/// fused multiply-adds from the bias on, in the order of the inputs, and the rational function of
/// kernels/shared/activation.h. Every processor and every number of frames therefore give equal bits.
void hidden_outputs(const HiddenLayer& layer, int frames, const Activations& x, Activations& o) noexcept;

/// Computes f of the output neuron, in four sums: (0 + 1) + (2 + 3). weights: [inputs + 1], the bias last; o:
/// [most_frames].
void output_neuron(const float* weights, int inputs, int frames, const Activations& x, float* o) noexcept;

}  // namespace tactel::infer
