// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace tactel::fem {

struct LegendrePoint {
  double x, weight;
};

/// Returns the points of Gauss and Legendre's rule on [-1, 1], left to right; exact for polynomials up to degree
/// 2 count - 1. Newton's iteration on the Legendre polynomial (Golub and Van Loan, Matrix Computations).
std::vector<LegendrePoint> legendre_points(int count);

/// Returns points and weights for integrals over [0, last] of what is smooth but near 0: legendre_points(count) on
/// panels that double from `first` up to `panel`, then have this width.
std::vector<LegendrePoint> points_on_doubling_panels(double first, double panel, double last, int count);

}  // namespace tactel::fem
