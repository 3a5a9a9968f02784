// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "nn/frame_set.h"

namespace tactel::nn {

/// The estimator without a network: S = c r, where r is a frame's sum of shear stresses over its sum of |normal
/// stresses|. Its sums are nearly Q and P, and S = Q / (mu P): with one friction coefficient c is about 1 / mu. Every
/// network should do better than it.

/// Returns r of each frame [rows], 1; NaN where no tactel has normal stress.
std::vector<double> shear_ratios(const FrameSet& set);

/// How c is fitted to the rows of a set that have a ratio other than 0.
enum class RatioFit {
  median,        ///< the median of S / r
  least_squares  ///< sum S r / sum r^2
};

/// Returns c. Throws ValueError, key "inputs", for a set of which no row has such a ratio.
double fit_shear_ratio(const FrameSet& set, RatioFit fit);

/// Returns |c r - S| of each row [rows]; NaN where there is no ratio.
std::vector<double> shear_ratio_errors(const FrameSet& set, double c);

}  // namespace tactel::nn
