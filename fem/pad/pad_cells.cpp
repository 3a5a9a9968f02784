// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactel::fem {
namespace {

/// The disc of n / 2 cells about the grid's middle.
bool in_disc(int n, int i, int j) {
  const int dx = 2 * i - n + 1, dy = 2 * j - n + 1;
  return dx * dx + dy * dy <= n * n;
}

/// Cells below a sharp round edge.
PadCells round_cells(double radius, int n) {
  int inside = 0;
  for (int k = 0; k < n * n; ++k) inside += in_disc(n, k / n, k % n);
  const double cells_a_radius = std::sqrt(inside / std::numbers::pi);
  const double h = radius / (cells_a_radius - round_overhang);
  return {.n = n, .hx = h, .hy = h, .round = true, .edge = {true, true, true, true}};
}

int rung_above(double h, double thickness) {
  return static_cast<int>(std::ceil(rungs_an_octave * std::log2(h / thickness) - 1e-9));
}

/// One direction of the grid.
struct Side {
  double h, middle;
  bool first_edge, last_edge;

  Side(const Interval& contact, const Interval& edges, int n) {
    const Interval clipped{std::max(contact.left, edges.left), std::min(contact.right, edges.right)};
    first_edge = clipped.left == edges.left, last_edge = clipped.right == edges.right;
    h = (clipped.right - clipped.left) / (n - straight_overhang * (first_edge + last_edge));
    middle = (clipped.left + clipped.right + straight_overhang * h * (last_edge - first_edge)) / 2;
  }
  bool free() const { return !first_edge && !last_edge; }
};

}  // namespace

bool PadCells::allowed(int i, int j) const {
  if (round) return in_disc(n, i, j);
  return !(i < 0 && edge[0]) && !(i >= n && edge[1]) && !(j < 0 && edge[2]) && !(j >= n && edge[3]);
}

bool solvable(const PadCells& cells, double thickness, double depth) {
  const auto [least, most] = solvable_sides(thickness, depth);
  return std::min(cells.hx, cells.hy) >= least && std::max(cells.hx, cells.hy) <= most;
}

PadCells pad_cells(const PadBox& contact, const PadIndenter& indenter, int n, double thickness, bool ladder) {
  if (const auto* punch = std::get_if<Punch>(&indenter.shape); punch && punch->edge == 0)
    return round_cells(punch->radius, n);
  const PadBox edges = pad_edges(indenter.shape);
  Side x(contact.x, edges.x, n), y(contact.y, edges.y, n);
  if (ladder) {
    int kx = rung_above(x.h, thickness), ky = rung_above(y.h, thickness);
    if (x.free() && y.free() && (kx - ky) % 2 != 0) ++(kx < ky ? kx : ky);
    if (x.free()) x.h = thickness * std::exp2(static_cast<double>(kx) / rungs_an_octave);
    if (y.free()) y.h = thickness * std::exp2(static_cast<double>(ky) / rungs_an_octave);
  }
  return {.n = n,
          .hx = x.h,
          .hy = y.h,
          .x_middle = x.middle,
          .y_middle = y.middle,
          .edge = {x.first_edge, x.last_edge, y.first_edge, y.last_edge}};
}

Eigen::MatrixXd cell_heights(const PadCells& cells, const PadIndenter& indenter) {
  Eigen::ArrayXd x(cells.n + 2), y(cells.n + 2);
  for (int i = -1; i <= cells.n; ++i) x[i + 1] = cells.x(i), y[i + 1] = cells.y(i);
  Eigen::MatrixXd heights = pad_heights(indenter, x, y);
  for (int i = -1; i <= cells.n; ++i)
    for (int j = -1; j <= cells.n; ++j)
      if (!cells.allowed(i, j)) heights(i + 1, j + 1) = std::numeric_limits<double>::infinity();
  return heights;
}

PadInfluence::PadInfluence(const PadLayer& layer, double thickness, double hx, double hy, int size) : n(size) {
  const Eigen::Index entries = at(n, n) + 1;
  zz.resize(entries), xx.resize(entries), yy.resize(entries), xy.resize(entries), xz.resize(entries),
      yz.resize(entries);
  const std::vector<CellInfluence> all = layer.influences(thickness, hx, hy, n);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const CellInfluence& c = all.data()[i * (n + 1) + j];
      for (const int sx : {-1, 1})
        for (const int sy : {-1, 1}) {
          const Eigen::Index k = at(-sx * i, -sy * j);  // the place lies at +(sx i, sy j) from the source
          zz[k] = c.zz, xx[k] = c.xx, yy[k] = c.yy;
          xy[k] = sx * sy * c.xy, xz[k] = sx * c.xz, yz[k] = sy * c.yz;
        }
    }
  own_normal = zz[at(0, 0)];
  own_tangential = std::max(xx[at(0, 0)], yy[at(0, 0)]);
}

}  // namespace tactel::fem
