// SPDX-License-Identifier: Apache-2.0
#include "host/networks/learning_inputs.h"

#include "fem/value_error.h"

namespace tactel::host {
namespace {

// The row of a set that the kernels read in place of rows that are not there.
constexpr std::uint32_t zero_rows = 1;

std::uint32_t checked_rows(const nn::FrameSet& set) {
  set.validate();
  if (set.rows() >= std::int64_t{1} << 31)
    throw ValueError("inputs", std::to_string(set.rows()) + " rows", "fewer than 2^31 rows");
  return static_cast<std::uint32_t>(set.rows());
}

}  // namespace

template <class Real>
LearningInputs<Real>::LearningInputs(const Device& device, const nn::FrameSet& set, const nn::InputScaling& scaling,
                                     std::span<const SetVariant> variants)
    : rows_(checked_rows(set)),
      variants_(static_cast<std::uint32_t>(variants.size())),
      inputs_(static_cast<int>(set.frames.cols())) {
  const int lanes = device.lanes(precision_of<Real>);
  row_size_ = (inputs_ + 1 + lanes - 1) / lanes * lanes;
  const std::size_t variant_size = std::size_t{rows_ + zero_rows} * row_size_;
  values_ = Buffer<Real>(device, variants.size() * variant_size);
  const auto view = values_.map(MapFor::writing);
  std::fill(view.view().begin(), view.view().end(), Real(0));
  for (std::size_t v = 0; v < variants.size(); ++v) {
    nn::FrameSet noisy = nn::with_noise(set, variants[v].noise, variants[v].seed);
    nn::take_differences(noisy.frames, set.history);
    const nn::RowMatrix<Real> scaled = nn::scale_frames<Real>(scaling, noisy.frames);
    for (std::uint32_t row = 0; row < rows_; ++row) {
      Real* to = &view[v * variant_size + std::size_t{row} * row_size_];
      std::copy_n(scaled.row(row).data(), inputs_, to);
      to[inputs_] = 1;
    }
  }
  std::vector<Real> targets(rows_ + zero_rows, Real(0));
  const nn::Vector<Real> target = nn::training_set<Real>(set, scaling).target;
  std::copy_n(target.data(), rows_, targets.data());
  targets_ = Buffer<Real>(device, std::span<const Real>(targets));
}

template class LearningInputs<float>;
template class LearningInputs<double>;

}  // namespace tactel::host
