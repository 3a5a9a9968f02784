// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "host/answers/line_error.h"

namespace tactel::host {

/// Returns the line of the share-quantile of errors over differences, [scenes] both: quantile regression (Koenker and
/// Bassett, Econometrica 46, 1978), with slopes 0, 0.05 ... 4 and `least` >= 0.
inline ErrorLine error_line(const std::vector<double>& differences, const std::vector<double>& errors, double share) {
  constexpr int slopes = 80;
  constexpr double slope_step = 0.05;
  ErrorLine best;
  double least_loss = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= slopes; ++k) {
    ErrorLine line{.slope = k * slope_step};
    std::vector<double> above;
    for (std::size_t i = 0; i < errors.size(); ++i) above.push_back(errors[i] - line.slope * differences[i]);
    line.least = std::max(0.0, covering_value(above, share));
    double loss = 0;
    for (const double a : above) loss += (a > line.least ? share : share - 1) * (a - line.least);
    if (loss < least_loss) least_loss = loss, best = line;
  }
  return best;
}

}  // namespace tactel::host
