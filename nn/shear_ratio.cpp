// SPDX-License-Identifier: Apache-2.0
#include "nn/shear_ratio.h"

#include <cmath>
#include <limits>

#include "fem/numbers/value_error.h"
#include "nn/metrics.h"

namespace tactel::nn {

std::vector<double> shear_ratios(const FrameSet& set) {
  const Eigen::Index tactels = set.frames.cols() / 2;
  std::vector<double> ratios(static_cast<std::size_t>(set.rows()));
  for (Eigen::Index row = 0; row < set.rows(); ++row) {
    const auto frame = set.frames.row(row).cast<double>();
    const double normal = frame.head(tactels).cwiseAbs().sum(), shear = frame.tail(tactels).sum();
    ratios[row] = normal > 0 ? shear / normal : std::numeric_limits<double>::quiet_NaN();
  }
  return ratios;
}

double fit_shear_ratio(const FrameSet& set, RatioFit fit) {
  const std::vector<double> ratios = shear_ratios(set);
  std::vector<double> quotients;
  double product = 0, square = 0;
  for (Eigen::Index row = 0; row < set.rows(); ++row) {
    const double r = ratios[row], s = set.slip_index(row);
    if (std::isnan(r) || r == 0) continue;
    quotients.push_back(s / r);
    product += s * r;
    square += r * r;
  }
  if (quotients.empty()) throw ValueError("inputs", "no row with shear and normal stress", "at least one such row");
  return fit == RatioFit::median ? quantile(std::move(quotients), 0.5) : product / square;
}

std::vector<double> shear_ratio_errors(const FrameSet& set, double c) {
  std::vector<double> errors = shear_ratios(set);
  for (Eigen::Index row = 0; row < set.rows(); ++row) errors[row] = std::abs(c * errors[row] - set.slip_index(row));
  return errors;
}

}  // namespace tactel::nn
