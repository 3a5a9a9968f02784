// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "host/device/buffer.h"
#include "host/device/executor.h"
#include "nn/frame_likelihood.h"

namespace tactel::host {

/// Launcher of kernels/frame_likelihood.cl: a bank of frames on a device. The bits of an answer depend on its row of
/// the bank and its reading alone.
template <class Real>
class FrameLikelihood {
 public:
  /// bank: [rows, model.size()] MPa, newest frame first; largest: [rows] MPa, as in nn::deviation, or empty. Throws
  /// ValueError for an invalid model, another width, no rows, and a row without stress in its newest frame, of which
  /// sigma would be 0.
  FrameLikelihood(Executor& executor, const nn::ReadingModel& model, const nn::RowMatrix<float>& bank,
                  std::span<const float> largest = {});

  /// Returns the logarithms of the densities of readings [readings, model.size()]: [readings, rows].
  nn::RowMatrix<Real> operator()(const nn::RowMatrix<float>& readings);

 private:
  Executor* executor_;
  nn::ReadingModel model_;
  Eigen::Index rows_;
  std::uint32_t vectors_;
  Buffer<Real> bank_, row_numbers_;
  Launch launch_;
};

extern template class FrameLikelihood<float>;
extern template class FrameLikelihood<double>;

}  // namespace tactel::host
