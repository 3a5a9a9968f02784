// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "nn/activation.h"
#include "nn/input_scaling.h"
#include "nn/weights.h"

namespace tactel::nn {

/// Outputs of every layer for one pattern: [0] the scaled inputs, then f of each layer's sums.
template <class Scalar>
using Activations = std::vector<Vector<Scalar>>;
/// -d E / d z of every layer of weights, E = 1/2 (target - output)^2: the delta of the rule.
template <class Scalar>
using Deltas = std::vector<Vector<Scalar>>;

/// Returns o_j = f(sum_i w_ji o_i + b_j), layer by layer (generalized delta rule, Rumelhart, Hinton and Williams
/// 1986, eq. 2 and 15, with the activation of the topology).
template <class Scalar>
Activations<Scalar> forward(const Weights<Scalar>& weights, const Vector<Scalar>& scaled_frame) {
  Activations<Scalar> o{scaled_frame};
  for (int l = 0; l < weights.topology.layers(); ++l) {
    const auto w = weights.layer(l);
    const int in = weights.topology.fan_in(l);
    const Vector<Scalar> z = w.leftCols(in) * o.back() + w.col(in);
    const Activation kind = weights.topology.activation(l);
    o.push_back(z.unaryExpr([kind](Scalar x) { return activation(kind, x); }));
  }
  return o;
}

/// Returns delta_out = error f' and delta_j = f'_j sum_k delta_k w_kj (same source, eq. 13 and 14). error: minus the
/// derivative of the loss by each output, target - output in the source; [outputs].
template <class Scalar>
Deltas<Scalar> backward(const Weights<Scalar>& weights, const Activations<Scalar>& o, const Vector<Scalar>& error) {
  const int layers = weights.topology.layers();
  const auto slopes = [&](int l) -> Vector<Scalar> {
    const Activation kind = weights.topology.activation(l);
    return o[l + 1].unaryExpr([kind](Scalar f) { return activation_slope(kind, f); });
  };
  Deltas<Scalar> delta(layers);
  delta[layers - 1] = error.cwiseProduct(slopes(layers - 1));
  for (int l = layers - 1; l > 0; --l) {
    const Vector<Scalar> back = weights.layer(l).leftCols(weights.topology.fan_in(l)).transpose() * delta[l];
    delta[l - 1] = slopes(l - 1).cwiseProduct(back);
  }
  return delta;
}

/// The same for one output.
template <class Scalar>
Deltas<Scalar> backward(const Weights<Scalar>& weights, const Activations<Scalar>& o, Scalar error) {
  return backward<Scalar>(weights, o, Vector<Scalar>::Constant(1, error));
}

/// Adds factor * delta_j o_i of one pattern to `sums`, in the shape of the weights. The input of the bias is 1.
template <class Scalar>
void add_outer(const Activations<Scalar>& o, const Deltas<Scalar>& delta, Scalar factor, Weights<Scalar>& sums) {
  for (int l = 0; l < sums.topology.layers(); ++l) {
    auto w = sums.layer(l);
    const int in = sums.topology.fan_in(l);
    w.leftCols(in).noalias() += (factor * delta[l]) * o[l].transpose();
    w.col(in) += factor * delta[l];
  }
}

/// Slippage index and status of many frames.
template <class Scalar>
struct Recall {
  Vector<Scalar> slip_index;        ///< [rows] 0..1; NaN where the status is not_finite or overflow
  std::vector<FrameStatus> status;  ///< [rows]
  /// [rows] quantiles of S where the network has the heads of a bound, else empty; NaN as slip_index.
  Vector<Scalar> upper{}, lower{};
  std::vector<BoundAnswer> bounds{};  ///< [rows] instead of the quantiles, where the bound was evaluated; of
                                      ///< kernels/forward.cl
};

/// Evaluates a network on frames [rows, inputs] in MPa, normal stresses first: the reference of
/// kernels/forward.cl.
template <class Scalar>
Recall<Scalar> recall(const Weights<Scalar>& weights, const InputScaling& scaling, const RowMatrix<float>& frames);

extern template Recall<float> recall(const Weights<float>&, const InputScaling&, const RowMatrix<float>&);
extern template Recall<double> recall(const Weights<double>&, const InputScaling&, const RowMatrix<float>&);

}  // namespace tactel::nn
