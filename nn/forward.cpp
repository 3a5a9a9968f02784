// SPDX-License-Identifier: Apache-2.0
#include "nn/forward.h"

#include <cmath>
#include <limits>
#include <string>

#include "fem/value_error.h"

namespace tactel::nn {

template <class Scalar>
Recall<Scalar> recall(const Weights<Scalar>& weights, const InputScaling& scaling, const RowMatrix<float>& frames) {
  const int inputs = weights.topology.inputs();
  if (frames.cols() != inputs)
    throw ValueError("inputs", std::to_string(frames.cols()) + " a frame",
                     std::to_string(inputs) + " for the network " + weights.topology.text());
  Recall<Scalar> result{Vector<Scalar>(frames.rows()), std::vector<FrameStatus>(frames.rows())};
  Vector<Scalar> scaled(inputs);
  for (Eigen::Index row = 0; row < frames.rows(); ++row) {
    FrameStatus status = scale_frame(scaling, frames.row(row).data(), inputs, scaled.data());
    const Scalar output = forward(weights, scaled).back()(0);
    if (status != FrameStatus::not_finite && std::isnan(output)) status = FrameStatus::overflow;
    const bool none = status == FrameStatus::not_finite || status == FrameStatus::overflow;
    result.slip_index(row) = none ? std::numeric_limits<Scalar>::quiet_NaN() : output + Scalar(0.5);
    result.status[row] = status;
  }
  return result;
}

template Recall<float> recall(const Weights<float>&, const InputScaling&, const RowMatrix<float>&);
template Recall<double> recall(const Weights<double>&, const InputScaling&, const RowMatrix<float>&);

}  // namespace tactel::nn
