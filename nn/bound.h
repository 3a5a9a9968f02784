// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "nn/quantile_heads.h"

namespace tactel::nn {

/// Returns a bound without corrections for a learning set's scaled frames [rows, inputs], which begin with the normal
/// stresses of `tactels`. Their covariance is taken
/// with a noise of 0.1 % of the divisor on every input, so that a direction in which noiseless frames never vary does
/// not make every real frame unlike them.
Bound uncalibrated_bound(const RowMatrix<float>& scaled, int tactels);

/// Returns the number of touched tactels of a scaled frame.
int touching_tactels(const float* scaled, int tactels);
/// Returns |(scaled - centre) * whitening|^2; infinity where it overflows.
float squared_distance(const Bound& bound, const float* scaled);
/// Returns the bound of a frame; NaN where the quantiles are. scaled: [inputs].
BoundAnswer bounded(const Bound& bound, const Quantiles<float>& quantiles, const float* scaled);

/// Returns the ceil((n + 1) level)-th smallest of n scores. Throws ValueError, key "rows", where n is so small that
/// this exceeds n.
double conformal_quantile(std::vector<double> scores, double level);
/// Returns the fewest scores of which conformal_quantile exists: 19 at 95 %.
std::size_t fewest_scores(double level);

/// A row to calibrate by.
struct CalibrationRow {
  Quantiles<float> quantiles;
  float slip_index = 0;  ///< true
  const float* scaled = nullptr;
};

/// Outcome of a calibration.
struct Calibration {
  std::size_t rows = 0, own_classes = 0, classes = 0;  ///< own_classes: with a correction of their own
  bool known = false;                                  ///< enough rows for unlike_above; else it stays as it was
};

/// Gives a bound the classes of today: the edges of a new one, and those of the distance at 60, 86, 94 and 98 % of the
/// rows' distances, where the rows suffice for unlike_above. The corrections become 0.
void renew_classes(Bound& bound, std::span<const CalibrationRow> rows);

/// Calibrates a bound anew: its corrections, at `level`, and unlike_above. A class of fewer than own_rows rows takes
/// the correction of all rows of its touching, width and distance, or of its touching, or of all. Throws ValueError as
/// conformal_quantile.
Calibration calibrate(Bound& bound, std::span<const CalibrationRow> rows, double level);

}  // namespace tactel::nn
