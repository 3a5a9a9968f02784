// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_surface.h"

#include <cmath>
#include <limits>

#include "fem/angles.h"

namespace tactel::fem {
namespace {

constexpr int points_of_cell = 8;  ///< along a side, where an edge runs through the cell: the cover is right to 1/16

/// Whether the indenter ends at edges without a rounding.
bool is_sharp(const PadShape& shape) {
  if (const auto* punch = std::get_if<Punch>(&shape)) return punch->edge == 0;
  if (const auto* box = std::get_if<Box>(&shape)) return box->edge == 0;
  return false;
}

PadIndenter enlarged(PadIndenter indenter, double by) {
  if (auto* punch = std::get_if<Punch>(&indenter.shape)) punch->radius += by;
  if (auto* box = std::get_if<Box>(&indenter.shape)) box->half_widths[0] += by, box->half_widths[1] += by;
  return indenter;
}

}  // namespace

PadCells fixed_cells(int n, double side) { return {.n = n, .hx = side, .hy = side}; }

PadSurface pad_surface(const PadCells& cells, const PadIndenter& indenter, std::array<double, 2> place, double yaw) {
  const bool sharp = is_sharp(indenter.shape);
  const PadIndenter edge = sharp ? enlarged(indenter, cover_overhang * cells.hx) : indenter;
  const double angle = radians(indenter.yaw + yaw), cosine = std::cos(angle), sine = std::sin(angle);
  const auto height = [&](const PadIndenter& of, double x, double y, bool beyond_edges) {
    const double px = x - place[0], py = y - place[1];
    return pad_height(of, cosine * px + sine * py, cosine * py - sine * px, beyond_edges);
  };
  PadSurface surface{Eigen::ArrayXd(cells.count()), Eigen::ArrayXd::Ones(cells.count())};
  for (int i = 0; i < cells.count(); ++i) {
    const double x = cells.x(i / cells.n), y = cells.y(i % cells.n);
    surface.height[i] = height(indenter, x, y, sharp);
    if (!sharp) continue;
    // Of points x points places in the cell those below the object; first and step are over its side.
    const auto below = [&](int points, double first, double step) {
      int count = 0;
      for (int a = 0; a < points; ++a)
        for (int b = 0; b < points; ++b)
          count +=
              std::isfinite(height(edge, x + (first + a * step) * cells.hx, y + (first + b * step) * cells.hy, false));
      return count;
    };
    if (below(2, -0.5, 1) == 4) continue;  // all corners
    const int inside = below(points_of_cell, 0.5 / points_of_cell - 0.5, 1.0 / points_of_cell);
    surface.cover[i] = inside / static_cast<double>(points_of_cell * points_of_cell);
    if (inside == 0) surface.height[i] = std::numeric_limits<double>::infinity();
  }
  return surface;
}

}  // namespace tactel::fem
