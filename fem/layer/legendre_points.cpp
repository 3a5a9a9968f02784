// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/legendre_points.h"

#include <cmath>
#include <numbers>

namespace tactel::fem {
namespace {

struct Legendre {
  double value, slope;
};

Legendre legendre(int degree, double x) {
  double before = 1, now = x;
  for (int k = 2; k <= degree; ++k) {
    const double next = ((2 * k - 1) * x * now - (k - 1) * before) / k;
    before = now;
    now = next;
  }
  return {now, degree * (x * now - before) / (x * x - 1)};
}

}  // namespace

std::vector<LegendrePoint> legendre_points(int count) {
  std::vector<LegendrePoint> points;
  for (int i = 0; i < count; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    for (int pass = 0; pass < 8; ++pass) {
      const Legendre at = legendre(count, x);
      x -= at.value / at.slope;
    }
    const double slope = legendre(count, x).slope;
    points.push_back({x, 2 / ((1 - x * x) * slope * slope)});
  }
  return points;
}

}  // namespace tactel::fem
