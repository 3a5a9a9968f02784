// SPDX-License-Identifier: Apache-2.0
#include "host/networks/learning_inputs.h"

#include "fem/numbers/value_error.h"

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
                                     std::span<const SetVariant> variants, const nn::LearningView& learning_view)
    : rows_(checked_rows(set)),
      variants_(static_cast<std::uint32_t>(variants.size())),
      inputs_(scaling.inputs(static_cast<int>(set.frames.cols()))) {
  const int lanes = device.lanes(precision_of<Real>);
  row_size_ = (inputs_ + 1 + lanes - 1) / lanes * lanes;
  const std::size_t variant_size = std::size_t{rows_ + zero_rows} * row_size_;
  values_ = Buffer<Real>(device, variants.size() * variant_size);
  const auto view = values_.map(MapFor::writing);
  const bool differences = set.history > 1 && learning_view.empty();
  for (std::size_t v = 0; v < variants.size(); ++v) {
    Real* const rows = &view[v * variant_size];
    if (variants[v].noise == 0 && !differences) {
      put_rows(scaling, set.frames, learning_view, rows);
    } else {
      nn::FrameSet noisy = nn::with_noise(set, variants[v].noise, variants[v].seed);
      if (differences) nn::take_differences(noisy.frames, set.history);
      put_rows(scaling, noisy.frames, learning_view, rows);
    }
  }
  targets_ = Buffer<Real>(device, rows_ + zero_rows);
  const auto targets = targets_.map(MapFor::writing);
  const nn::Vector<Real> target = nn::targets<Real>(set);
  std::copy_n(target.data(), rows_, targets.view().data());
  targets[rows_] = 0;
}

// The rows of one variant, [rows + 1][row_size].
template <class Real>
void LearningInputs<Real>::put_rows(const nn::InputScaling& scaling, const nn::RowMatrix<float>& frames,
                                    const nn::LearningView& learning_view, Real* rows) const {
  nn::scale_frames(scaling, frames, rows, row_size_);
  for (std::uint32_t row = 0; row < rows_; ++row) {
    learning_view.apply(rows + std::size_t{row} * row_size_);
    Real* const rest = rows + std::size_t{row} * row_size_ + inputs_;
    rest[0] = 1;
    std::fill(rest + 1, rest + row_size_ - inputs_, Real(0));
  }
  std::fill_n(rows + std::size_t{rows_} * row_size_, row_size_, Real(0));
}

template class LearningInputs<float>;
template class LearningInputs<double>;

}  // namespace tactel::host
