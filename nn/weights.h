// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <vector>

#include "nn/topology.h"

namespace tactel::nn {

template <class Scalar>
using RowMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
template <class Scalar>
using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

/// The weights of one network, or anything of the same shape (steps of the momentum, gradients).
template <class Scalar>
struct Weights {
  explicit Weights(const Topology& topology) : topology(topology), values(topology.weight_count(), Scalar(0)) {}
  template <class Other>
  explicit Weights(const Weights<Other>& other)
      : topology(other.topology), values(other.values.begin(), other.values.end()) {}

  /// [out, in + 1]: the bias in the last column.
  Eigen::Map<RowMatrix<Scalar>> layer(int l) {
    return {values.data() + topology.layer_offset(l), topology.fan_out(l), topology.fan_in(l) + 1};
  }
  Eigen::Map<const RowMatrix<Scalar>> layer(int l) const {
    return {values.data() + topology.layer_offset(l), topology.fan_out(l), topology.fan_in(l) + 1};
  }

  Topology topology;
  std::vector<Scalar> values;  ///< [layer][out][in + 1]
};

/// Returns true where every weight is finite.
template <class Scalar>
bool all_finite(const Weights<Scalar>& weights) {
  return Eigen::Map<const Vector<Scalar>>(weights.values.data(), static_cast<Eigen::Index>(weights.values.size()))
      .allFinite();
}

/// Half width of the interval of initial weights: the range of the program that came with the description of the
/// rule (McClelland and Rumelhart 1988, chapter 5, program bp: wrange = 1, weights within +-0.5).
inline constexpr float initial_weight_bound = 0.5f;

/// Returns initial weights, uniform in +-initial_weight_bound, biases included. Weight i of network (topology,
/// seed) is equal on every machine: word i % 4 of draw i / 4. Leaky rectifiers start from a variance of 2 / fan in (He,
/// Zhang, Ren and Sun 2015), the outputs behind them from 1 / fan in, with biases of 0.
Weights<float> initial_weights(const Topology& topology, std::uint64_t seed);

}  // namespace tactel::nn
