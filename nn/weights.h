// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <cstdint>

#include "nn/network.h"

namespace tactel::nn {

template <class Scalar>
using RowMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
template <class Scalar>
using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

template <class Scalar>
auto Weights<Scalar>::layer(int l) {
  return Eigen::Map<RowMatrix<Scalar>>(values.data() + topology.layer_offset(l), topology.fan_out(l),
                                       topology.fan_in(l) + 1);
}
template <class Scalar>
auto Weights<Scalar>::layer(int l) const {
  return Eigen::Map<const RowMatrix<Scalar>>(values.data() + topology.layer_offset(l), topology.fan_out(l),
                                             topology.fan_in(l) + 1);
}

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
