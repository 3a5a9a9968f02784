// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

namespace tactel::fem {

/// J0, J1, J2 and their slopes.
struct Bessel {
  explicit Bessel(double x) {
    value[0] = ::j0(x);
    value[1] = ::j1(x);
    const double half = x / 2, q = half * half;
    const double J1_by_x = x < 1e-8 ? 0.5 : value[1] / x;
    // The recurrence cancels where x is small; there the series has six terms at most.
    double J2_by_x = x < 1 ? x / 8 * (1 - q / 3 * (1 - q / 8 * (1 - q / 15 * (1 - q / 24 * (1 - q / 35)))))
                           : (2 * J1_by_x - value[0]) / x;
    value[2] = J2_by_x * x;
    slope[0] = -value[1];
    slope[1] = value[0] - J1_by_x;
    slope[2] = value[1] - 2 * J2_by_x;
  }
  double value[3], slope[3];
};

}  // namespace tactel::fem
