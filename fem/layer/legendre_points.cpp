// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/legendre_points.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace tactel::fem {
namespace {

struct Legendre {
  double value, slope;
};

Legendre legendre(int degree, double x) {
  double before = 1, value = x;
  for (int k = 2; k <= degree; ++k) {
    const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
    before = value;
    value = next;
  }
  return {value, degree * (x * value - before) / (x * x - 1)};
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

std::vector<LegendrePoint> points_on_doubling_panels(double first, double panel, double last, int count) {
  std::vector<double> ends = {0};
  double end = first;
  while (end < panel) ends.push_back(std::exchange(end, 2 * end));
  for (int k = 1; k * panel <= last; ++k) ends.push_back(k * panel);
  const std::vector<LegendrePoint> gauss = legendre_points(count);
  std::vector<LegendrePoint> points;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double middle = (ends[i - 1] + ends[i]) / 2, half = (ends[i] - ends[i - 1]) / 2;
    for (const LegendrePoint& g : gauss) points.push_back({middle + half * g.x, half * g.weight});
  }
  return points;
}

}  // namespace tactel::fem
