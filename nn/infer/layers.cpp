// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/layers.h"

#include "nn/infer/processors.h"

// Outside of namespace tactel, whose functions the library shows: clang shows what chooses a variant.
namespace {

using tactel::infer::tile;

static_assert(tactel::infer::widest_layer % tile == 0);

constexpr float leak = 0.01f;  // nn::leak

inline __attribute__((always_inline)) float fused(float a, float b, float c) { return __builtin_fmaf(a, b, c); }

/// kernels/shared/activation.h, fp32.
inline __attribute__((always_inline)) float activation(float z) {
  constexpr float end = 16.0f;
  z = z > end ? end : z;
  z = z < -end ? -end : z;
  const float u = z * z;
  float p = 0x1.05a58ap-36f;
  p = fused(p, u, 0x1.6f52cap-24f);
  p = fused(p, u, 0x1.d421dap-15f);
  p = fused(p, u, 0x1.1357bep-7f);
  p = fused(p, u, 0x1.0p-2f);
  float q = 0x1.c98802p-29f;
  q = fused(q, u, 0x1.65b1dp-18f);
  q = fused(q, u, 0x1.acad1ap-10f);
  q = fused(q, u, 0x1.df012ep-4f);
  q = fused(q, u, 1.0f);
  return z * p / q;
}

FOR_EACH_PROCESSOR void sum_tiles(const tactel::infer::HiddenLayer& layer, const float* x, float* o) noexcept {
  const int inputs = layer.inputs;
  const float* w = layer.weights.data();
  for (int t = 0; t < layer.tiles; ++t, o += tile) {
    float z[tile];
    for (int j = 0; j < tile; ++j) z[j] = w[inputs * tile + j];
    for (int i = 0; i < inputs; ++i, w += tile)
      for (int j = 0; j < tile; ++j) z[j] = fused(w[j], x[i], z[j]);
    w += tile;
    if (layer.leaky)
      for (int j = 0; j < tile; ++j) o[j] = z[j] > 0 ? z[j] : leak * z[j];
    else
      for (int j = 0; j < tile; ++j) o[j] = activation(z[j]);
  }
}

FOR_EACH_PROCESSOR float sum_output(const float* weights, int inputs, const float* x) noexcept {
  float sum[4] = {weights[inputs], 0, 0, 0};
  for (int k = 0; k < inputs; ++k) sum[k % 4] = fused(weights[k], x[k], sum[k % 4]);
  return activation((sum[0] + sum[1]) + (sum[2] + sum[3]));
}

}  // namespace

namespace tactel::infer {

HiddenLayer hidden_layer(const FileLayer& layer) {
  HiddenLayer made{layer.inputs, layer.outputs, (layer.outputs + tile - 1) / tile, layer.leaky, {}};
  const std::size_t rows = layer.inputs + 1;
  made.weights.assign(made.tiles * rows * tile, 0.0f);
  for (int j = 0; j < layer.outputs; ++j) {
    float* const column = made.weights.data() + (j / tile) * rows * tile + j % tile;
    for (int i = 0; i < layer.inputs; ++i) column[i * tile] = layer.weights[std::size_t(j) * layer.inputs + i];
    column[std::size_t(layer.inputs) * tile] = layer.bias[j];
  }
  return made;
}

void hidden_outputs(const HiddenLayer& layer, const float* x, float* o) noexcept { sum_tiles(layer, x, o); }

float output_neuron(const float* weights, int inputs, const float* x) noexcept {
  return sum_output(weights, inputs, x);
}

}  // namespace tactel::infer
