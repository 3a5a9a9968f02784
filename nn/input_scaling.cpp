// SPDX-License-Identifier: Apache-2.0
#include "nn/input_scaling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "fem/numbers/value_error.h"
#include "nn/features.h"

namespace tactel::nn {

const char* name(FrameStatus status) {
  constexpr std::array names{"ok", "no stress", "not finite", "overflow"};
  const auto place = static_cast<std::size_t>(status);
  return place < names.size() ? names[place] : "unknown";
}

namespace {

/// scale_frame by the set or the frame, of finite stresses.
template <class Scalar>
FrameStatus scale_stresses(const InputScaling& scaling, const float* frame, int numbers, Scalar* scaled) {
  float divisor = scaling.largest_stress;
  Scalar scale(1);
  if (scaling.kind == ScalingKind::frame) {
    divisor = 0.0f;
    for (int k = 0; k < scaling.normals(numbers); ++k) divisor = std::max(divisor, std::abs(frame[k]));
    if (divisor < InputScaling::smallest_stress) return FrameStatus::no_stress;
    if (divisor > InputScaling::large_stress) scale = Scalar(InputScaling::large_scale);
  }
  const Scalar factor = Scalar(1) / (Scalar(divisor) * scale);
  const int count = scaling.width(numbers) * scaling.history;
  std::transform(frame, frame + count, scaled, [=](float x) { return Scalar(x) * scale * factor; });
  if (scaling.features != Features::frame) add_features(scaling, numbers, Scalar(divisor), scaled);
  return FrameStatus::ok;
}

}  // namespace

template <class Scalar>
FrameStatus scale_frame(const InputScaling& scaling, const float* frame, int numbers, Scalar* scaled) {
  const auto not_finite = [](float x) { return !std::isfinite(x); };
  std::fill(scaled, scaled + scaling.inputs(numbers), Scalar(0));
  if (std::any_of(frame, frame + numbers, not_finite)) return FrameStatus::not_finite;
  FrameStatus status = FrameStatus::no_stress;
  if (scaling.kind != ScalingKind::rest)
    status = scale_stresses(scaling, frame, numbers, scaled);
  else if (take_differences_to_rest(scaling, numbers, frame, scaled))
    status = FrameStatus::ok;
  if (scaling.friction && status == FrameStatus::ok)
    tell_friction(Scalar(frame[numbers - 2]), Scalar(frame[numbers - 1]), scaled + scaling.inputs(numbers) - 2);
  return status;
}

template <class Scalar>
void scale_frames(const InputScaling& scaling, const RowMatrix<float>& frames, Scalar* scaled, Eigen::Index stride) {
  const auto numbers = static_cast<int>(frames.cols());
  for (Eigen::Index row = 0; row < frames.rows(); ++row, scaled += stride) {
    const FrameStatus status = scale_frame(scaling, frames.row(row).data(), numbers, scaled);
    const bool finite =
        (Eigen::Map<const Vector<Scalar>>(scaled, scaling.inputs(numbers)).array() * Scalar(0)).sum() == Scalar(0);
    if (status == FrameStatus::not_finite || !finite)
      throw ValueError("inputs[" + std::to_string(row) + "]", "NaN or infinity", "finite, also after scaling");
  }
}

template <class Scalar>
RowMatrix<Scalar> scale_frames(const InputScaling& scaling, const RowMatrix<float>& frames) {
  RowMatrix<Scalar> scaled(frames.rows(), scaling.inputs(static_cast<int>(frames.cols())));
  scale_frames(scaling, frames, scaled.data(), scaled.cols());
  return scaled;
}

template FrameStatus scale_frame(const InputScaling&, const float*, int, float*);
template FrameStatus scale_frame(const InputScaling&, const float*, int, double*);
template RowMatrix<float> scale_frames(const InputScaling&, const RowMatrix<float>&);
template RowMatrix<double> scale_frames(const InputScaling&, const RowMatrix<float>&);
template void scale_frames(const InputScaling&, const RowMatrix<float>&, float*, Eigen::Index);
template void scale_frames(const InputScaling&, const RowMatrix<float>&, double*, Eigen::Index);

}  // namespace tactel::nn
