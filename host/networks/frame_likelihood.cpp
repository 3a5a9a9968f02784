// SPDX-License-Identifier: Apache-2.0
#include "host/networks/frame_likelihood.h"

#include <cmath>
#include <string>
#include <vector>

#include "fem/value_error.h"
#include "host/networks/learning_inputs.h"
#include "kernels/shared/likelihood_layout.h"

namespace tactel::host {
namespace {

constexpr std::size_t together = LIKELIHOOD_READINGS;

/// 1 / sigma^2, and what the logarithm of a density has of its row alone.
struct RowNumbers {
  double over_variance = 0, constant = 0;
};

RowNumbers row_numbers(const nn::ReadingModel& model, std::span<const float> truth, double largest) {
  const double sigma = nn::deviation(model, truth, largest);
  if (!(sigma > 0 && std::isfinite(sigma)))
    throw ValueError("inputs", "a row without stress, or not finite", "rows of contacts that press on a tactel");
  double constant = -model.size() * std::log(sigma);
  for (int t = 0; t < model.inputs; ++t) {
    double ff = 0;
    for (int m = 0; m < model.history; ++m) ff += std::pow(truth[m * model.inputs + t] / sigma, 2);
    constant -= 0.5 * std::log1p(model.gain * model.gain * ff);
  }
  return {1 / (sigma * sigma), constant};
}

void expect_width(const nn::ReadingModel& model, Eigen::Index width) {
  if (width != model.size())
    throw ValueError("inputs", std::to_string(width) + " a row", std::to_string(model.size()) + " a row");
}

}  // namespace

template <class Real>
FrameLikelihood<Real>::FrameLikelihood(Executor& executor, const nn::ReadingModel& model,
                                       const nn::RowMatrix<float>& bank, std::span<const float> largest)
    : executor_(&executor), model_(model), rows_(bank.rows()) {
  model.validate();
  expect_width(model, bank.cols());
  if (rows_ < 1 || rows_ >= Eigen::Index{1} << 31)
    throw ValueError("inputs", std::to_string(rows_) + " rows", "1 to 2^31 - 1 rows");
  const Device& device = executor.device();
  const auto lanes = static_cast<std::size_t>(device.lanes(precision_of<Real>));
  const auto size = static_cast<std::size_t>(model.size());
  vectors_ = static_cast<std::uint32_t>((static_cast<std::size_t>(rows_) + lanes - 1) / lanes);
  std::vector<Real> frames(vectors_ * size * lanes, Real(0)), numbers(vectors_ * 2 * lanes, Real(0));
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows_); ++row) {
    const std::span truth(bank.row(static_cast<Eigen::Index>(row)).data(), size);
    const RowNumbers own = row_numbers(model, truth, largest.empty() ? 0 : largest[row]);
    const std::size_t vector = row / lanes, lane = row % lanes;
    for (int t = 0; t < model.inputs; ++t)
      for (int m = 0; m < model.history; ++m)
        frames[(vector * size + static_cast<std::size_t>(t * model.history + m)) * lanes + lane] =
            static_cast<Real>(truth[m * model.inputs + t]);
    numbers[2 * vector * lanes + lane] = static_cast<Real>(own.over_variance);
    numbers[(2 * vector + 1) * lanes + lane] = static_cast<Real>(own.constant);
  }
  bank_ = Buffer<Real>(device, std::span<const Real>(frames));
  row_numbers_ = Buffer<Real>(device, std::span<const Real>(numbers));
  const Buffer<Real> none(device, 1);
  const Program program(device, "frame_likelihood.cl",
                        {{"LANES", std::to_string(lanes)},
                         {"REAL", real_type(precision_of<Real>)},
                         {"INPUTS", std::to_string(model.inputs)},
                         {"HISTORY", std::to_string(model.history)}});
  launch_ = executor.prepare(program, "frame_likelihood", [&](KernelArguments& kernel) {
    kernel.set("bank", bank_);
    kernel.set("rows", row_numbers_);
    kernel.set("readings", none);
    kernel.set("out", none);
    kernel.set("vectors", vectors_);
    kernel.set("reading_groups", std::uint32_t{1});
    kernel.set("gain2", static_cast<Real>(model.gain * model.gain));
  });
}

template <class Real>
nn::RowMatrix<Real> FrameLikelihood<Real>::operator()(const nn::RowMatrix<float>& readings) {
  expect_width(model_, readings.cols());
  const Device& device = executor_->device();
  const auto count = static_cast<std::size_t>(readings.rows()), size = static_cast<std::size_t>(model_.size());
  const std::size_t groups = (count + together - 1) / together;
  const std::size_t width = static_cast<std::size_t>(vectors_) * device.lanes(precision_of<Real>);
  if (count == 0) return nn::RowMatrix<Real>(0, rows_);
  std::vector<Real> packed(groups * size * together, Real(0));
  for (std::size_t k = 0; k < count; ++k)
    for (int t = 0; t < model_.inputs; ++t)
      for (int m = 0; m < model_.history; ++m)
        packed[(k / together * size + static_cast<std::size_t>(t * model_.history + m)) * together + k % together] =
            readings(static_cast<Eigen::Index>(k), m * model_.inputs + t);
  const Buffer<Real> given(device, std::span<const Real>(packed));
  const Buffer<Real> out(device, groups * together * width);
  launch_.bind([&](KernelArguments& kernel) {
    kernel.set("readings", given);
    kernel.set("out", out);
    kernel.set("reading_groups", static_cast<std::uint32_t>(groups));
  });
  executor_->run(launch_, groups * ((vectors_ + LIKELIHOOD_VECTORS - 1) / LIKELIHOOD_VECTORS));
  nn::RowMatrix<Real> answer(readings.rows(), rows_);
  const typename Buffer<Real>::Mapping view(out);
  for (Eigen::Index k = 0; k < readings.rows(); ++k)
    std::copy_n(view.view().data() + static_cast<std::size_t>(k) * width, rows_, answer.row(k).data());
  return answer;
}

template class FrameLikelihood<float>;
template class FrameLikelihood<double>;

}  // namespace tactel::host
