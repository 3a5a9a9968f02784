// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "host/device/buffer.h"
#include "host/device/device.h"
#include "nn/frame_set.h"
#include "nn/learning_view.h"

namespace tactel::host {

/// A learning set, without or with added noise (nn::with_noise).
struct SetVariant {
  double noise = 0;        ///< standard deviation over the set's largest |stress|
  std::uint64_t seed = 0;  ///< of the noise
};

/// Learning sets on a device in the layout of the training kernels: rows scaled and padded to whole vectors. Frames
/// behind the newest are differences to it (nn::take_differences); nn::weights_of_frames undoes that in the weights.
/// With features they are as nn::LearningView shows them. Cheap to copy.
template <class Real>
class LearningInputs {
 public:
  /// Uploads the variants of one set, with equal scaling. Throws ValueError for an unusable set.
  LearningInputs(const Device& device, const nn::FrameSet& set, const nn::InputScaling& scaling,
                 std::span<const SetVariant> variants, const nn::LearningView& learning_view = {});

  std::uint32_t rows() const { return rows_; }
  std::uint32_t variants() const { return variants_; }
  int inputs() const { return inputs_; }
  int row_size() const { return row_size_; }  ///< numbers in a row: inputs, 1 for the bias, zeros to whole vectors
  const Buffer<Real>& rows_buffer() const { return values_; }  ///< [variants][rows + 1][row_size], the last row zeros
  const Buffer<Real>& targets_buffer() const { return targets_; }  ///< [rows + 1] S - 0.5; the last unused

 private:
  void put_rows(const nn::InputScaling& scaling, const nn::RowMatrix<float>& frames,
                const nn::LearningView& learning_view, Real* rows) const;

  std::uint32_t rows_, variants_;
  int inputs_, row_size_;
  Buffer<Real> values_, targets_;
};

extern template class LearningInputs<float>;
extern template class LearningInputs<double>;

}  // namespace tactel::host
