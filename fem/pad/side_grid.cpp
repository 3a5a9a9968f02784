// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/side_grid.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {
namespace {

/// Four equally spaced nodes around a place and their weights in the cubic through them; `at` in steps from node 0.
struct Cubic {
  int first;
  std::array<double, 4> weight;

  Cubic(double at, int count) : first(std::clamp(static_cast<int>(std::floor(at)) - 1, 0, count - 4)) {
    for (int k = 0; k < 4; ++k) {
      weight[k] = 1;
      for (int l = 0; l < 4; ++l)
        if (l != k) weight[k] *= (at - first - l) / (k - l);
    }
  }
};

}  // namespace

SideGrid::Shares SideGrid::shares(double x, double y) const {
  constexpr double rounding = 1e-9;
  Shares all{};
  if (std::abs(x) > sides[0] / 2 + rounding || std::abs(y) > sides[1] / 2 + rounding) return all;
  const auto [nx, ny] = cells;
  const Cubic in_x((x / sides[0] + 0.5) * nx - 0.5, nx), in_y((y / sides[1] + 0.5) * ny - 0.5, ny);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      all.node[all.count] = (in_x.first + i) * ny + in_y.first + j;
      all.share[all.count++] = in_x.weight[i] * in_y.weight[j];
    }
  return all;
}

}  // namespace tactel::fem
