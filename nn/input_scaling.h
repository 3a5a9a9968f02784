// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "nn/weights.h"

namespace tactel::nn {

/// Status of the evaluation of a frame. No output with status `ok` is NaN.
enum class FrameStatus : std::uint8_t {
  ok = 0,
  no_stress = 1,   ///< scaling by frame, but the frame has no normal stress; the network received zeros
  not_finite = 2,  ///< the frame contains NaN or infinity; the slippage index is NaN
  overflow = 3,    ///< the frame is finite, but a sum inside the network is not; the slippage index is NaN
};

/// Returns "ok", "no stress", "not finite" or "overflow".
const char* name(FrameStatus status);

/// Scales one input [numbers], stresses in MPa, of each frame the normal stresses first, and what is told, as the
/// kernels do: times the reciprocal of the divisor, both in Scalar; then its features. A frame that is not finite, or
/// carries no stress, becomes zeros. scaled: [scaling.inputs(numbers)].
template <class Scalar>
FrameStatus scale_frame(const InputScaling& scaling, const float* frame, int numbers, Scalar* scaled);

/// The same for every row of [rows, numbers]. Throws ValueError, key "inputs[row]", at the first row that is not
/// finite.
template <class Scalar>
RowMatrix<Scalar> scale_frames(const InputScaling& scaling, const RowMatrix<float>& frames);
/// The same into rows that begin `stride` numbers apart.
template <class Scalar>
void scale_frames(const InputScaling& scaling, const RowMatrix<float>& frames, Scalar* scaled, Eigen::Index stride);

extern template FrameStatus scale_frame(const InputScaling&, const float*, int, float*);
extern template FrameStatus scale_frame(const InputScaling&, const float*, int, double*);
extern template RowMatrix<float> scale_frames(const InputScaling&, const RowMatrix<float>&);
extern template RowMatrix<double> scale_frames(const InputScaling&, const RowMatrix<float>&);
extern template void scale_frames(const InputScaling&, const RowMatrix<float>&, float*, Eigen::Index);
extern template void scale_frames(const InputScaling&, const RowMatrix<float>&, double*, Eigen::Index);

}  // namespace tactel::nn
