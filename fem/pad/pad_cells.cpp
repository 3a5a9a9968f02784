// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/numbers/angles.h"

namespace tactel::fem {
namespace {

/// The disc of n / 2 cells about the grid's middle.
bool in_disc(int n, int i, int j) {
  const int dx = 2 * i - n + 1, dy = 2 * j - n + 1;
  return dx * dx + dy * dy <= n * n;
}

/// Cells below a sharp round edge.
PadCells round_cells(double radius, int n, double overhang) {
  int inside = 0;
  for (int k = 0; k < n * n; ++k) inside += in_disc(n, k / n, k % n);
  const double cells_a_radius = std::sqrt(inside / std::numbers::pi);
  const double h = radius / (cells_a_radius - overhang);
  return {.n = n, .hx = h, .hy = h, .round = true, .edge = {true, true, true, true}};
}

int rung_above(double h, double thickness) {
  return static_cast<int>(std::ceil(rungs_an_octave * std::log2(h / thickness) - 1e-9));
}

/// One direction of the grid.
struct Side {
  double h, middle;
  bool first_edge, last_edge;

  Side(const Interval& contact, const Interval& edges, int n, double overhang = straight_overhang) {
    const Interval clipped{std::max(contact.left, edges.left), std::min(contact.right, edges.right)};
    first_edge = clipped.left == edges.left, last_edge = clipped.right == edges.right;
    h = (clipped.right - clipped.left) / (n - overhang * (first_edge + last_edge));
    middle = (clipped.left + clipped.right + overhang * h * (last_edge - first_edge)) / 2;
  }
  /// On rubber that ends.
  Side(const Interval& contact, const Interval& edges, const Interval& rubber, int n)
      : Side(contact, edges, n, straight_overhang_of_means) {
    const double left = middle - n * h / 2, right = middle + n * h / 2, rounding = 1e-9 * (right - left);
    const bool ends_left = left <= rubber.left + rounding, ends_right = right >= rubber.right - rounding;
    const double first = ends_left ? rubber.left : left, last = ends_right ? rubber.right : right;
    first_edge |= ends_left, last_edge |= ends_right;
    h = (last - first) / n, middle = (first + last) / 2;
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
  const double reach =
      std::hypot(std::max(-contact.x.left, contact.x.right), std::max(-contact.y.left, contact.y.right));
  const auto inside = [&](double radius) { return indenter.curvature > 0 && reach < radius; };  // a skin that falls off
  if (const auto* punch = std::get_if<Punch>(&indenter.shape); punch && punch->edge == 0 && !inside(punch->radius))
    return round_cells(punch->radius, n, round_overhang);
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

PadCells pad_cells(const PadBox& contact, const PadIndenter& indenter, int n, const PadBox& rubber, double turn) {
  const auto holds = [&](const PadBox& part) {
    return part.x.left >= rubber.x.left && part.x.right <= rubber.x.right && part.y.left >= rubber.y.left &&
           part.y.right <= rubber.y.right;
  };
  bool shared = turn != 0;
  if (const auto* punch = std::get_if<Punch>(&indenter.shape); punch && punch->edge == 0) {
    const PadCells cells = round_cells(punch->radius, n, round_overhang_of_means);
    if (holds(cells.box())) return cells;
    shared = true;
  }
  const PadBox edges = shared ? everywhere : pad_edges(indenter.shape);
  const Side x(contact.x, edges.x, rubber.x, n), y(contact.y, edges.y, rubber.y, n);
  return {.n = n,
          .hx = x.h,
          .hy = y.h,
          .x_middle = x.middle,
          .y_middle = y.middle,
          .edge = {x.first_edge, x.last_edge, y.first_edge, y.last_edge},
          .turn = turn,
          .shared = shared};
}

namespace {

/// Calls f(share, height) at points of a cell, with its height where it is covered; shares sum to 1.
template <class F>
void over_shared_cell(const PadCells& cells, const PadIndenter& indenter, int i, int j, F f) {
  constexpr int points = 16;
  const double cosine = std::cos(radians(cells.turn)), sine = std::sin(radians(cells.turn));
  for (int p = 0; p < points; ++p)
    for (int q = 0; q < points; ++q) {
      const double x = cells.x(i) + ((p + 0.5) / points - 0.5) * cells.hx,
                   y = cells.y(j) + ((q + 0.5) / points - 0.5) * cells.hy;
      const double height = pad_height(indenter, cosine * x - sine * y, sine * x + cosine * y);
      if (std::isfinite(height)) f(1.0 / (points * points), height);
    }
}

}  // namespace

Eigen::MatrixXd covered_shares(const PadCells& cells, const PadIndenter& indenter) {
  Eigen::MatrixXd shares = Eigen::MatrixXd::Ones(cells.n + 2, cells.n + 2);
  if (!cells.shared) return shares;
  shares.setZero();
  for (int i = -1; i <= cells.n; ++i)
    for (int j = -1; j <= cells.n; ++j)
      over_shared_cell(cells, indenter, i, j, [&](double share, double) { shares(i + 1, j + 1) += share; });
  return shares;
}

double share_compliance(double share, const PadCells& cells, double poisson) {
  const double g = 0.68 * (1 / share - 1) / (1 + 0.07 / share);
  return g * std::sqrt(cells.area()) * (1 - poisson * poisson) / (1 - 0.48 * 0.48);
}

namespace {

/// Heights of shared cells: at the middle where all is covered.
Eigen::MatrixXd shared_heights(const PadCells& cells, const PadIndenter& indenter) {
  constexpr double least_share = 0.01;
  const Eigen::MatrixXd shares = covered_shares(cells, indenter);
  const Eigen::Rotation2Dd turn(radians(cells.turn));
  Eigen::MatrixXd heights =
      Eigen::MatrixXd::Constant(cells.n + 2, cells.n + 2, std::numeric_limits<double>::infinity());
  for (int i = -1; i <= cells.n; ++i)
    for (int j = -1; j <= cells.n; ++j) {
      const double covered = shares(i + 1, j + 1);
      double& height = heights(i + 1, j + 1);
      if (covered < least_share || !cells.allowed(i, j)) continue;
      height = 0;
      if (covered > 1 - 1e-9) {
        const Eigen::Vector2d own = turn * Eigen::Vector2d(cells.x(i), cells.y(j));
        height = pad_height(indenter, own[0], own[1]);
      } else {
        over_shared_cell(cells, indenter, i, j, [&](double share, double h) { height += share / covered * h; });
      }
    }
  return heights;
}

}  // namespace

Eigen::MatrixXd cell_heights(const PadCells& cells, const PadIndenter& indenter) {
  if (cells.shared) return shared_heights(cells, indenter);
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
