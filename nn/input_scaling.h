// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

#include "nn/frame_status.h"
#include "nn/weights.h"

namespace tactel::nn {

/// Divisor of a frame in MPa, applied before the network; part of the network's file. `set`: the largest |stress|
/// of the learning set (the paper's). `frame`: the frame's own largest |normal stress|, so that S does not depend
/// on E or on a common factor of all stresses.
enum class ScalingKind { set, frame };

const char* name(ScalingKind kind);
/// Returns the kind named "set" or "frame". Throws ValueError, key "scaling".
ScalingKind parse_scaling(std::string_view text);

struct InputScaling {
  ScalingKind kind = ScalingKind::set;
  float largest_stress = 1.0f;  ///< MPa, > 0: the divisor of `set`; unused by `frame`
  int history = 1;              ///< frames in an input; `frame` divides all of them by the newest's, which is the first

  /// MPa: below it, a normal stress counts as none. A frame without larger ones carries no stress (`frame`
  /// only).
  static constexpr float smallest_stress = 1e-12f;
  /// MPa: the reciprocal of more is no normal number in fp32. No learning set may hold more (`set`); a frame with more
  /// is first taken times large_scale (`frame`), which keeps its bits.
  static constexpr float large_stress = 0x1p126f, large_scale = 0x1p-8f;
  bool operator==(const InputScaling&) const = default;
  void validate() const;  ///< throws ValueError, key "scaling"
};

/// Scales one input [inputs] MPa, of each frame the normal stresses first, as the kernels do: times the reciprocal of
/// the divisor, both in Scalar. A frame that is not finite, or carries no stress, becomes zeros.
template <class Scalar>
FrameStatus scale_frame(const InputScaling& scaling, const float* frame, int inputs, Scalar* scaled);

/// The same for every row of [rows, inputs]. Throws ValueError, key "inputs[row]", at the first row that is not finite.
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
