// SPDX-License-Identifier: Apache-2.0

#include "nn/infer/layers.h"

// Outside of namespace tactel, whose functions the library shows: clang shows what chooses a variant.
namespace {

using tactel::infer::tile;

static_assert(tactel::infer::widest_layer % tile == 0 && tactel::infer::most_frames == 4);

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

inline __attribute__((always_inline)) void activations(bool leaky, const float* z, float* o) {
  if (leaky)
    for (int j = 0; j < tile; ++j) o[j] = z[j] > 0 ? z[j] : leak * z[j];
  else
    for (int j = 0; j < tile; ++j) o[j] = activation(z[j]);
}

FOR_EACH_PROCESSOR void sum_one(const tactel::infer::HiddenLayer& layer, const float* x, float* o) noexcept {
  const int inputs = layer.inputs;
  const float* w = layer.weights.data();
  for (int t = 0; t < layer.tiles; ++t, o += tile) {
    float z[tile];
    for (int j = 0; j < tile; ++j) z[j] = w[inputs * tile + j];
    for (int i = 0; i < inputs; ++i, w += tile)
      for (int j = 0; j < tile; ++j) z[j] = fused(w[j], x[i], z[j]);
    w += tile;
    activations(layer.leaky, z, o);
  }
}

/// The same for four frames. Their sums are four arrays: compilers keep one with two indices in memory.
FOR_EACH_PROCESSOR void sum_four(const tactel::infer::HiddenLayer& layer, const float* x, float* o) noexcept {
  constexpr int b = tactel::infer::widest_layer, c = 2 * b, d = 3 * b;  // where the other frames begin
  const int inputs = layer.inputs;
  const float* w = layer.weights.data();
  for (int t = 0; t < layer.tiles; ++t, o += tile) {
    float za[tile], zb[tile], zc[tile], zd[tile];
    for (int j = 0; j < tile; ++j) za[j] = zb[j] = zc[j] = zd[j] = w[inputs * tile + j];
    for (int i = 0; i < inputs; ++i, w += tile) {
      const float xa = x[i], xb = x[b + i], xc = x[c + i], xd = x[d + i];
      for (int j = 0; j < tile; ++j) {
        za[j] = fused(w[j], xa, za[j]);
        zb[j] = fused(w[j], xb, zb[j]);
        zc[j] = fused(w[j], xc, zc[j]);
        zd[j] = fused(w[j], xd, zd[j]);
      }
    }
    w += tile;
    activations(layer.leaky, za, o);
    activations(layer.leaky, zb, o + b);
    activations(layer.leaky, zc, o + c);
    activations(layer.leaky, zd, o + d);
  }
}

FOR_EACH_PROCESSOR void sum_outputs(const float* weights, int inputs, int frames, const float* x, float* o) noexcept {
  float z[tactel::infer::most_frames] = {};
  for (int f = 0; f < frames; ++f, x += tactel::infer::widest_layer) {
    float sum[4] = {weights[inputs], 0, 0, 0};
    for (int k = 0; k < inputs; ++k) sum[k % 4] = fused(weights[k], x[k], sum[k % 4]);
    z[f] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
  for (int f = 0; f < tactel::infer::most_frames; ++f) o[f] = activation(z[f]);
}

}  // namespace

namespace tactel::infer {

HiddenLayer hidden_layer(const nn::Weights<float>& weights, int l) {
  const int inputs = weights.topology.fan_in(l), outputs = weights.topology.fan_out(l);
  HiddenLayer made{
      inputs, outputs, (outputs + tile - 1) / tile, weights.topology.activation(l) == nn::Activation::leaky_relu, {}};
  const std::size_t rows = inputs + 1;
  made.weights.assign(made.tiles * rows * tile, 0.0f);
  const float* weight = weights.values.data() + weights.topology.layer_offset(l);
  for (int j = 0; j < outputs; ++j) {
    float* const column = made.weights.data() + (j / tile) * rows * tile + j % tile;
    for (std::size_t i = 0; i < rows; ++i) column[i * tile] = *weight++;
  }
  return made;
}

void hidden_outputs(const HiddenLayer& layer, int frames, const Activations& x, Activations& o) noexcept {
  (frames == 1 ? sum_one : sum_four)(layer, x.values[0], o.values[0]);
}

void output_neuron(const float* weights, int inputs, int frames, const Activations& x, float* o) noexcept {
  sum_outputs(weights, inputs, frames, x.values[0], o);
}

}  // namespace tactel::infer
