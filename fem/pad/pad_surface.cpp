// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/numbers/angles.h"
#include "fem/pad/side_kernel.h"

namespace tactel::fem {
namespace {

constexpr int points_of_cell = 8;  ///< along a side, where an edge runs through the cell: the cover is right to 1/16
constexpr int points_of_means = 16;

/// What an indenter turned by `angle` lies above: larger by this part of a cell's sides along its own axes, and level.
PadIndenter enlarged(PadIndenter indenter, double part, const PadCells& cells, double angle) {
  indenter.tilt = 0;
  const double across = std::pow(std::sin(angle), 2), more = cells.hy - cells.hx;
  const double by_x = part * (cells.hx + across * more), by_y = part * (cells.hy - across * more);
  if (auto* punch = std::get_if<Punch>(&indenter.shape)) punch->radius += (by_x + by_y) / 2;
  if (auto* box = std::get_if<Box>(&indenter.shape)) box->half_widths[0] += by_x, box->half_widths[1] += by_y;
  return indenter;
}

/// Height of an indenter at a place of the pad.
class PlacedIndenter {
 public:
  PlacedIndenter(std::array<double, 2> place, double angle)
      : place_(place), cosine_(std::cos(angle)), sine_(std::sin(angle)) {}
  double height(const PadIndenter& of, double x, double y, bool beyond_edges) const {
    const double px = x - place_[0], py = y - place_[1];
    return pad_height(of, cosine_ * px + sine_ * py, cosine_ * py - sine_ * px, beyond_edges);
  }

 private:
  std::array<double, 2> place_;
  double cosine_, sine_;
};

}  // namespace

PadCells fixed_cells(std::array<int, 2> along, std::array<double, 2> sides) {
  return {.n = along[0], .hx = sides[0], .hy = sides[1], .along_y = along[1]};
}

void add_skin(const PadSensor& sensor, const PadCells& cells, Eigen::Ref<Eigen::ArrayXd> heights) {
  for (int i = 0; i < cells.count(); ++i)
    heights[i] += fall_of_skin(sensor, cells.x(i / cells.ny()), cells.y(i % cells.ny()));
}

PadSurface pad_surface(const PadCells& cells, const PadIndenter& indenter, std::array<double, 2> place, double yaw,
                       bool free_sides) {
  const bool sharp = pad_edge(indenter.shape) == PadEdge::sharp;
  const double angle = radians(indenter.yaw + yaw);
  const PlacedIndenter placed(place, angle);
  const PadIndenter edge =
      sharp ? enlarged(indenter, free_sides ? cover_overhang_of_means : cover_overhang, cells, angle) : indenter;
  PadSurface surface{Eigen::ArrayXd(cells.count()), Eigen::ArrayXd::Ones(cells.count())};
  for (int i = 0; i < cells.count(); ++i) {
    const double x = cells.x(i / cells.ny()), y = cells.y(i % cells.ny());
    surface.height[i] = placed.height(indenter, x, y, sharp);
    if (!sharp) continue;
    // Of points x points places in the cell those below the object; first and step are over its side.
    const auto below = [&](int points, double first, double step) {
      int count = 0;
      for (int a = 0; a < points; ++a)
        for (int b = 0; b < points; ++b)
          count += std::isfinite(
              placed.height(edge, x + (first + a * step) * cells.hx, y + (first + b * step) * cells.hy, false));
      return count;
    };
    if (below(2, -0.5, 1) == 4) continue;  // all corners
    const int points = free_sides ? points_of_means : points_of_cell;
    const int inside = below(points, 0.5 / points - 0.5, 1.0 / points);
    surface.cover[i] = inside / static_cast<double>(points * points);
    if (inside == 0) surface.height[i] = std::numeric_limits<double>::infinity();
  }
  return surface;
}

double height_beyond(const PadCells& cells, const PadIndenter& indenter, std::array<double, 2> place, double yaw,
                     const PadBox& rubber) {
  const double rounding = 1e-6 * cells.half_size();
  const PadBox grid = cells.box();
  const PlacedIndenter placed(place, radians(indenter.yaw + yaw));
  double least = std::numeric_limits<double>::infinity();
  const auto look = [&](double x, double y) {
    x = std::clamp(x, rubber.x.left, rubber.x.right), y = std::clamp(y, rubber.y.left, rubber.y.right);
    const bool inside = x >= grid.x.left - rounding && x <= grid.x.right + rounding && y >= grid.y.left - rounding &&
                        y <= grid.y.right + rounding;
    if (!inside) least = std::min(least, placed.height(indenter, x, y, false));
  };
  const int nx = cells.n, ny = cells.ny();
  for (int i = -1; i <= nx; ++i)
    for (int j = -1; j <= ny; j += i < 0 || i == nx ? 1 : ny + 1) look(cells.x(i), cells.y(j));
  look(place[0], place[1]);
  return least;
}

}  // namespace tactel::fem
