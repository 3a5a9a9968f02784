// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/layer_means.h"

#include <cmath>

#include "fem/layer/legendre_points.h"

namespace tactel::fem {

std::vector<CellInfluence> layer_means(const PadLayer& layer, double thickness, double hx, double hy, int n) {
  constexpr int near = 2;  // cells; farther ones see a smooth field
  const std::vector<LegendrePoint> many = legendre_points(8), few = legendre_points(5);
  std::vector<CellInfluence> means((n + 1) * (n + 1));
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      CellInfluence& mean = means[i * (n + 1) + j];
      const auto& points = i <= near && j <= near ? many : few;
      for (const LegendrePoint& p : points)
        for (const LegendrePoint& q : points) {
          const CellInfluence c = layer.influence(thickness, hx, hy, (i + p.x / 2) * hx, (j + q.x / 2) * hy);
          const double w = p.weight * q.weight / 4;
          mean.zz += w * c.zz, mean.xx += w * c.xx, mean.yy += w * c.yy;
          mean.xy += w * c.xy, mean.xz += w * c.xz, mean.yz += w * c.yz;
        }
    }
  return means;
}

PadBaseStress uniform_base_stress(const PadLayer& layer, double thickness, double hx, double hy, double x, double y) {
  // Of parts that PadLayer takes as uniform.
  const auto parts = [&](double h) { return static_cast<int>(std::ceil(h / (PadLayer::narrow_cell * thickness))); };
  const int nx = parts(hx), ny = parts(hy);
  PadBaseStress sum = PadBaseStress::Zero();
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      sum += layer.base_stress(thickness, hx / nx, hy / ny, x - hx * ((i + 0.5) / nx - 0.5),
                               y - hy * ((j + 0.5) / ny - 0.5));
  return sum;
}

}  // namespace tactel::fem
