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

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Height of a cell, h wide across the edge, whose middle lies `beyond` the end of a flat.
double rim_height(double beyond, double h, double strength, double edge, double most) {
  const auto rounding = [edge](double x) { return x > 0 ? x * x / (2 * edge) : 0; };
  const double reach = rim_reach(strength, edge);
  if (!(reach > 0 && reach < most * h)) return rounding(beyond);
  const double outline = rim_outline(reach, h), within = (outline - beyond) / h + 0.5;
  if (within < 0.5) return infinity;
  const double lacks = within < 1.5 ? 1 - within : 0;
  return rounding(std::min(beyond, outline - h / 2)) + lacks * std::numbers::pi * strength * std::sqrt(h);
}

/// The profile of a flat with a rim.
double rounded_height(const PadCells& cells, const PadIndenter& indenter, double x, double y) {
  const auto strength = [&](double at_x, double at_y) { return cells.rim.at(tilt_height(indenter, at_x, at_y)); };
  const double plane = tilt_height(indenter, x, y);
  if (const auto* punch = std::get_if<Punch>(&indenter.shape)) {
    const double r = std::hypot(x, y), cosine = r > 0 ? x / r : 1, sine = r > 0 ? y / r : 0;
    return plane + rim_height(r - punch->radius, std::hypot(cells.hx * cosine, cells.hy * sine),
                              strength(punch->radius * cosine, punch->radius * sine), punch->edge, round_rim);
  }
  const Box& box = std::get<Box>(indenter.shape);
  const double a = box.half_widths[0], b = box.half_widths[1];
  const double along_x = strength(std::copysign(a, x), std::clamp(y, -b, b)),
               along_y = strength(std::clamp(x, -a, a), std::copysign(b, y));
  return plane + rim_height(std::abs(x) - a, cells.hx, along_x, box.edge, straight_rim) +
         rim_height(std::abs(y) - b, cells.hy, along_y, box.edge, straight_rim);
}

}  // namespace

double rim_reach(double strength, double edge) {
  return std::cbrt(std::pow(1.5 * std::numbers::pi * edge * strength, 2));
}

double rim_outline(double reach, double h) {
  return reach + straight_overhang * h - (1 - rim_end) * std::min(reach, rim_end * h);
}

bool PadCells::allowed(int i, int j) const {
  if (round) return in_disc(n, i, j);
  return !(i < 0 && edge[0]) && !(i >= n && edge[1]) && !(j < 0 && edge[2]) && !(j >= n && edge[3]);
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
  Eigen::MatrixXd heights;
  if (cells.rim.strength > 0)
    heights = Eigen::MatrixXd::NullaryExpr(cells.n + 2, cells.n + 2, [&](Eigen::Index i, Eigen::Index j) {
      return rounded_height(cells, indenter, x[i], y[j]);
    });
  else
    heights = pad_heights(indenter, x, y);
  for (int i = -1; i <= cells.n; ++i)
    for (int j = -1; j <= cells.n; ++j)
      if (!cells.allowed(i, j)) heights(i + 1, j + 1) = infinity;
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
