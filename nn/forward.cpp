// SPDX-License-Identifier: Apache-2.0
#include "nn/forward.h"

#include <limits>
#include <string>

#include "fem/numbers/value_error.h"
#include "nn/quantile_heads.h"

namespace tactel::nn {

template <class Scalar>
Recall<Scalar> recall(const Weights<Scalar>& weights, const InputScaling& scaling, const RowMatrix<float>& frames) {
  const int inputs = weights.topology.inputs(), numbers = scaling.numbers(inputs);
  if (frames.cols() != numbers)
    throw ValueError("inputs", std::to_string(frames.cols()) + " a frame",
                     std::to_string(numbers) + " for the network " + weights.topology.text());
  Recall<Scalar> result{Vector<Scalar>(frames.rows()), std::vector<FrameStatus>(frames.rows())};
  const bool bound = weights.topology.has_bound();
  if (bound) result.upper = result.lower = result.slip_index;
  constexpr Scalar nan = std::numeric_limits<Scalar>::quiet_NaN();
  Vector<Scalar> scaled(inputs);
  for (Eigen::Index row = 0; row < frames.rows(); ++row) {
    FrameStatus status = scale_frame(scaling, frames.row(row).data(), numbers, scaled.data());
    const Vector<Scalar> output = forward(weights, scaled).back();
    if (status != FrameStatus::not_finite && output.hasNaN()) status = FrameStatus::overflow;
    const bool none = status == FrameStatus::not_finite || status == FrameStatus::overflow;
    result.slip_index(row) = none ? nan : output(0) + Scalar(0.5);
    if (bound) {
      const Quantiles<Scalar> q = quantiles(output);
      result.upper(row) = none ? nan : q.upper;
      result.lower(row) = none ? nan : q.lower;
    }
    result.status[row] = status;
  }
  return result;
}

template Recall<float> recall(const Weights<float>&, const InputScaling&, const RowMatrix<float>&);
template Recall<double> recall(const Weights<double>&, const InputScaling&, const RowMatrix<float>&);

}  // namespace tactel::nn
