// SPDX-License-Identifier: Apache-2.0
#include "nn/input_scaling.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "fem/value_error.h"
#include "nn/features.h"

namespace tactel::nn {

const char* name(FrameStatus status) {
  switch (status) {
    case FrameStatus::ok:
      return "ok";
    case FrameStatus::no_stress:
      return "no stress";
    case FrameStatus::not_finite:
      return "not finite";
    case FrameStatus::overflow:
      return "overflow";
  }
  return "unknown";
}

namespace {

/// scale_frame by the rest, of finite stresses.
template <class Scalar>
FrameStatus scale_differences(const InputScaling& scaling, const float* frame, int stresses, Scalar* scaled) {
  const int width = stresses / scaling.history, shown = width * scaling.shown();
  const float* const rest = frame + shown;
  const auto small = [](float x) { return Scalar(x) * Scalar(InputScaling::rest_scale); };
  Scalar P(0);
  for (int k = 0; k < scaling.normals(stresses); ++k) P = P - small(rest[k]);
  if (!(P >= small(InputScaling::smallest_stress))) return FrameStatus::no_stress;
  const Scalar factor = Scalar(1) / P;
  for (int k = 0; k < shown; ++k) scaled[k] = (small(frame[k]) - small(rest[k % width])) * factor;
  if (scaling.features != Features::frame) add_features(scaling, stresses, Scalar(0), scaled);
  return FrameStatus::ok;
}

}  // namespace

template <class Scalar>
FrameStatus scale_frame(const InputScaling& scaling, const float* frame, int stresses, Scalar* scaled) {
  const auto not_finite = [](float x) { return !std::isfinite(x); };
  std::fill(scaled, scaled + scaling.inputs(stresses), Scalar(0));
  if (std::any_of(frame, frame + stresses, not_finite)) return FrameStatus::not_finite;
  if (scaling.kind == ScalingKind::rest) return scale_differences(scaling, frame, stresses, scaled);
  float divisor = scaling.largest_stress;
  Scalar scale(1);
  if (scaling.kind == ScalingKind::frame) {
    divisor = 0.0f;
    for (int k = 0; k < scaling.normals(stresses); ++k) divisor = std::max(divisor, std::abs(frame[k]));
    if (divisor < InputScaling::smallest_stress) return FrameStatus::no_stress;
    if (divisor > InputScaling::large_stress) scale = Scalar(InputScaling::large_scale);
  }
  const Scalar factor = Scalar(1) / (Scalar(divisor) * scale);
  std::transform(frame, frame + stresses, scaled, [=](float x) { return Scalar(x) * scale * factor; });
  if (scaling.features != Features::frame) add_features(scaling, stresses, Scalar(divisor), scaled);
  return FrameStatus::ok;
}

template <class Scalar>
void scale_frames(const InputScaling& scaling, const RowMatrix<float>& frames, Scalar* scaled, Eigen::Index stride) {
  const auto stresses = static_cast<int>(frames.cols());
  for (Eigen::Index row = 0; row < frames.rows(); ++row, scaled += stride) {
    const FrameStatus status = scale_frame(scaling, frames.row(row).data(), stresses, scaled);
    const bool finite =
        (Eigen::Map<const Vector<Scalar>>(scaled, scaling.inputs(stresses)).array() * Scalar(0)).sum() == Scalar(0);
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
