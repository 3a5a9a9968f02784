// SPDX-License-Identifier: Apache-2.0
#include "nn/learning_view.h"

#include <algorithm>
#include <cmath>

namespace tactel::nn {
namespace {

constexpr Eigen::Index most_rows = 20000;  ///< that mean and deviation are taken of
constexpr float least_spread = 0.01f;      ///< of inputs that hardly change, such as the sign of a symmetric sum

}  // namespace

template <class Use>
void LearningView::each_difference(const Use& use) const {
  const int width = scaling_.width(numbers_), sums = scaling_.shown() * width;
  for (int frame = 1; frame < scaling_.shown(); ++frame) {
    for (int k = 0; k < width; ++k) use(frame * width + k, k);
    for (int k = 0; k < scaling_.sums(); ++k) use(sums + frame * scaling_.sums() + k, sums + k);
  }
}

LearningView::LearningView(const InputScaling& scaling, const RowMatrix<float>& frames)
    : scaling_(scaling), numbers_(static_cast<int>(frames.cols())) {
  if (scaling.features == Features::frame && scaling.kind != ScalingKind::rest && !scaling.friction) return;
  RowMatrix<float> inputs = scale_frames<float>(scaling, frames.topRows(std::min(frames.rows(), most_rows)));
  for (Eigen::Index row = 0; row < inputs.rows(); ++row)
    each_difference([x = inputs.row(row).data()](int place, int newest) { x[place] -= x[newest]; });
  for (Eigen::Index k = 0; k < inputs.cols(); ++k) {
    const Eigen::ArrayXd column = inputs.col(k).cast<double>().array();
    const double mean = column.mean();
    mean_.push_back(static_cast<float>(mean));
    deviation_.push_back(std::max(static_cast<float>(std::sqrt((column - mean).square().mean())), least_spread));
  }
}

template <class Scalar>
void LearningView::apply(Scalar* inputs) const noexcept {
  if (empty()) return;
  each_difference([inputs](int place, int newest) { inputs[place] -= inputs[newest]; });
  for (std::size_t k = 0; k < mean_.size(); ++k) inputs[k] = (inputs[k] - Scalar(mean_[k])) / Scalar(deviation_[k]);
}

template <class Scalar>
Weights<Scalar> LearningView::weights_of_inputs(const Weights<Scalar>& weights) const {
  Weights<Scalar> folded = weights;
  if (empty()) return folded;
  auto first = folded.layer(0);
  for (Eigen::Index k = 0; k + 1 < first.cols(); ++k) {
    first.col(k) /= Scalar(deviation_[static_cast<std::size_t>(k)]);
    first.rightCols(1) -= first.col(k) * Scalar(mean_[static_cast<std::size_t>(k)]);
  }
  each_difference([&](int place, int newest) { first.col(newest) -= first.col(place); });
  return folded;
}

template void LearningView::apply(float*) const noexcept;
template void LearningView::apply(double*) const noexcept;
template Weights<float> LearningView::weights_of_inputs(const Weights<float>&) const;
template Weights<double> LearningView::weights_of_inputs(const Weights<double>&) const;

}  // namespace tactel::nn
