// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_layer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/layer/legendre_points.h"

namespace tactel::fem {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double base_near = 0.5;  ///< H: from where on the base stress varies

/// Gauss points along a side of a cell. They leave 1e-10 of an influence up to 1 H.
const std::vector<LegendrePoint>& points_along(double side) {
  static const std::vector<LegendrePoint> few = legendre_points(4), some = legendre_points(6),
                                          many = legendre_points(16);
  return side <= 0.25 ? few : side <= 1 ? some : many;
}

/// Points along a side about `at`, and their shares, for what varies as 1 / rho from `near` on; the side lies `beside`
/// rho = 0. Where that is near, panels grow threefold from there.
std::vector<LegendrePoint> points_about_zero(double side, double at, double beside, double near) {
  static const auto rules = [] {
    std::array<std::vector<LegendrePoint>, 11> all;
    for (int count = 4; count <= 10; ++count) all[count] = legendre_points(count);
    return all;
  }();
  std::vector<LegendrePoint> points;
  const auto add = [&](double left, double right, int count) {
    for (const LegendrePoint& p : rules[count])
      points.push_back({(left + right) / 2 + (right - left) / 2 * p.x, (right - left) / (2 * side) * p.weight});
  };
  const double left = at - side / 2, right = at + side / 2, z = 2 * std::max({std::abs(at), beside, near}) / side;
  if (z >= 2) {
    constexpr double digits = 13;  // of 1e-11 over the convergence of Gauss's
                                   // rule (L. N. Trefethen, SIAM Rev. 50, 2008)
    add(left, right, std::clamp(static_cast<int>(std::ceil(digits / std::acosh(z))), side <= 0.25 ? 4 : 6, 10));
    return points;
  }
  std::vector<double> ends{left, right};
  if (left < 0 && right > 0) ends.push_back(0);
  double end = std::max(near, beside);
  while (end < std::max(-left, right)) {
    for (const double place : {-end, end})
      if (place > left && place < right) ends.push_back(place);
    end *= 3;
  }
  std::ranges::sort(ends);
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) add(ends[k], ends[k + 1], 10);
  return points;
}

/// Places along a side of a cell at which the rest of its normal influence is taken, from its middle, in units of H.
std::vector<double> rest_places(double side) {
  if (side <= PadLayer::least_parted) return {0};
  const int parts = std::min(static_cast<int>(2 * side) + 1, PadLayer::most_parts);
  std::vector<double> places;
  for (int part = 0; part < parts; ++part)
    for (const int sign : {-1, 1})
      places.push_back(side * ((part + 0.5 + sign * 0.5 / std::numbers::sqrt3) / parts - 0.5));
  return places;
}

double along_x(double x, double y) { return y * std::asinh(x / std::abs(y)); }

/// What I_xx, I_yy, I_xy, I_x and I_y have at a corner.
Eigen::Array<double, 5, 1> corner(double x, double y) {
  const double R = std::sqrt(x * x + y * y), ln_R = std::log(R);
  return {along_x(x, y), along_x(y, x), -R, y * ln_R + x * std::atan(y / x), x * ln_R + y * std::atan(x / y)};
}

/// [F] of cells hx x hy at offsets of 0 to nx and ny cells, [nx + 1][ny + 1]. Neighbours share corners.
std::vector<Eigen::Array<double, 5, 1>> half_spaces(double hx, double hy, int nx, int ny) {
  std::vector<Eigen::Array<double, 5, 1>> corners, all;  // [nx + 2][ny + 2]
  for (int i = 0; i < nx + 2; ++i)
    for (int j = 0; j < ny + 2; ++j) corners.push_back(corner((i - 0.5) * hx, (j - 0.5) * hy));
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j) {
      const auto* at = corners.data() + i * (ny + 2) + j;
      all.emplace_back(at[ny + 3] - at[1] - at[ny + 2] + at[0]);
    }
  return all;
}

/// The same of one cell at any offset.
Eigen::Array<double, 5, 1> half_space_of(double hx, double hy, double x, double y) {
  const double x0 = x - hx / 2, x1 = x + hx / 2, y0 = y - hy / 2, y1 = y + hy / 2;
  return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
}

/// Of an object by [F].
CellInfluence influence_of(const SoftObject& object, const Eigen::Array<double, 5, 1>& half_space) {
  const double nu = object.poisson, c = object.softness * (1 + nu) / pi;
  return {.zz = c * (1 - nu) * (half_space[0] + half_space[1]),
          .xx = c * (half_space[0] + (1 - nu) * half_space[1]),
          .yy = c * ((1 - nu) * half_space[0] + half_space[1]),
          .xy = c * nu * half_space[2],
          .xz = -c / 2 * (1 - 2 * nu) * half_space[3],
          .yz = -c / 2 * (1 - 2 * nu) * half_space[4]};
}

/// The integral of the quadratic B-spline from 0 to r.
double spline_integral(double r) {
  const double q = std::abs(r);
  const double integral = q < 0.5 ? q * (0.75 - q * q / 3) : 0.5 - std::pow(std::max(0.0, 1.5 - q), 3) / 6;
  return std::copysign(integral, r);
}

}  // namespace

PadLayer::PadLayer(double poisson)
    : PadLayer(poisson, PadIntegrals::sampled(std::vector{PadIntegrals(poisson)}, places()).front()) {}

PadLayer::PadLayer(double poisson, const PadSamples& samples) : poisson_(poisson) { add_cells(places(), samples); }

PadLayer::PadLayer(const std::vector<RubberLayer>& layers, int below)
    : poisson_(layers.back().poisson), deep_(height_above(layers, below)) {
  constexpr double lengths = 16;  // leave 1e-7
  double H = 0;
  for (const RubberLayer& layer : layers) H += layer.thickness;
  near_ = layers.back().thickness / H;
  soft_thickness_ = fem::soft_thickness(layers);
  reach_ = std::max(range, lengths * shear_length(layers));
  const auto count = static_cast<Eigen::Index>(std::ceil(steps_a_thickness * std::asinh(reach_ / near_)));
  Eigen::VectorXd ends = Eigen::VectorXd::LinSpaced(count + 1, 0, static_cast<double>(count) / steps_a_thickness);
  for (double& end : ends) end = near_ * std::sinh(end);
  PadSamples samples(2 * pad_integrals, ends.size());
  double farthest = near_;
  for (Eigen::Index k = 0; k < ends.size();) {
    const PadIntegrals integrals(layers, farthest, below);
    for (; k < ends.size() && ends[k] <= farthest; ++k) {
      const PadIntegrals::At at = integrals.at(ends[k]);
      samples.col(k) << at.value, at.slope;
    }
    farthest *= 2;
  }
  ends_.assign(ends.begin(), ends.end());
  add_cells(ends, samples);
}

/// Of integrals and slopes at the ends of the cells.
void PadLayer::add_cells(const Eigen::VectorXd& ends, const PadSamples& samples) {
  for (Eigen::Index cell = 0; cell + 1 < samples.cols(); ++cell) {
    const double step = ends_.empty() ? 1.0 / steps_a_thickness : ends[cell + 1] - ends[cell];
    const auto left = samples.col(cell), right = samples.col(cell + 1);
    auto& row = cells_.emplace_back();
    for (int f = 0; f < pad_integrals; ++f) {
      const double rise = right[f] - left[f], s0 = step * left[pad_integrals + f], s1 = step * right[pad_integrals + f];
      row[f] = {left[f], s0, 3 * rise - 2 * s0 - s1, s0 + s1 - 2 * rise};
    }
  }
}

Eigen::VectorXd PadLayer::places() {
  constexpr auto count = static_cast<Eigen::Index>(range * steps_a_thickness);
  return Eigen::VectorXd::LinSpaced(count + 1, 0, range);
}

std::vector<PadLayer::Share> PadLayer::shares(double side) {
  if (side <= narrow_cell) return {{0, 1}};
  const int parts = PadLayer::parts(side), last = 5 * parts / 2;
  const double way = std::min(1.0, (side - narrow_cell) / (wide_cell - narrow_cell)),
               smooth = way * way * (3 - 2 * way);
  std::vector<Share> all;
  for (int k = -last; k <= last; ++k) {
    const double left = (k - 0.5) / parts, right = (k + 0.5) / parts;
    const auto spline = [&](double shift) { return spline_integral(right - shift) - spline_integral(left - shift); };
    all.push_back({static_cast<double>(k) / parts, (1 - smooth) * (2 * std::abs(k) < parts ? 1.0 / parts : 0) +
                                                       smooth * (1.25 * spline(0) - (spline(-1) + spline(1)) / 8)});
  }
  return all;
}

double PadLayer::value_of_layers(PadIntegral f, double rho) const {
  const double place = steps_a_thickness * std::asinh(rho / near_);
  const auto cell = std::min(static_cast<std::size_t>(place), cells_.size() - 1);
  const double q = (rho - ends_[cell]) / (ends_[cell + 1] - ends_[cell]);
  const Cubic& c = cells_[cell][f];
  return c[0] + q * (c[1] + q * (c[2] + q * c[3]));
}

double PadLayer::value(PadIntegral f, double rho) const {
  if (!ends_.empty()) return value_of_layers(f, rho);
  const double place = rho * steps_a_thickness;
  const auto cell = std::min(static_cast<std::size_t>(place), cells_.size() - 1);
  const double q = place - static_cast<double>(cell);
  const Cubic& c = cells_[cell][f];
  return c[0] + q * (c[1] + q * (c[2] + q * c[3]));
}

/// Calls f(x, y, weight) at Gauss points of a cell about (x, y); weights sum to 1. All in units of H. What is averaged
/// varies from `near` on.
template <class F>
void PadLayer::over_cell(double hx, double hy, double x, double y, double near, F f) const {
  if (ends_.empty()) {
    for (const LegendrePoint& p : points_along(hx))
      for (const LegendrePoint& q : points_along(hy)) f(x - hx / 2 * p.x, y - hy / 2 * q.x, p.weight * q.weight / 4);
    return;
  }
  const std::vector<LegendrePoint> along_x = points_about_zero(hx, x, std::abs(y) - hy / 2, near),
                                   along_y = points_about_zero(hy, y, std::abs(x) - hx / 2, near);
  for (const LegendrePoint& p : along_x)
    for (const LegendrePoint& q : along_y) f(p.x, q.x, p.weight * q.weight);
}

/// Beyond the range the rest is the negative of the half-space's part.
Eigen::Array4d PadLayer::displacements(double rho) const {
  if (rho >= reach_) return {-1 / rho, (poisson_ - 2) / rho, poisson_ / rho, (2 * poisson_ - 1) / rho};
  return {value(pad_z0, rho), value(pad_A, rho), value(pad_B, rho), value(pad_Z, rho)};
}

Eigen::Array<double, 5, 1> PadLayer::stresses(double rho) const {
  Eigen::Array<double, 5, 1> b = Eigen::Array<double, 5, 1>::Zero();
  if (rho < reach_)
    b << value(pad_b0, rho), value(pad_bA, rho), value(pad_bB, rho), value(pad_bxz, rho), value(pad_bzx, rho);
  return b;
}

Eigen::MatrixXd PadLayer::normal_influence(double thickness, double hx, double hy, int n) const {
  if (!ends_.empty()) {
    const std::vector<CellInfluence> all = influences(thickness, hx, hy, n - 1);
    return Eigen::MatrixXd::NullaryExpr(n, n, [&](Eigen::Index i, Eigen::Index j) { return all[i * n + j].zz; });
  }
  hx /= thickness, hy /= thickness;
  Eigen::MatrixXd corner(n + 1, n + 1), zz(n, n);  // neighbours share corners
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double x = (i - 0.5) * hx, y = (j - 0.5) * hy;
      corner(i, j) = along_x(x, y) + along_x(y, x);
    }
  const double more = 1 + object_.normal() / (1 - poisson_ * poisson_);
  const std::vector<double> places_x = rest_places(hx), places_y = rest_places(hy);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      double rest = 0;
      for (const double x : places_x)
        for (const double y : places_y) {
          const double rho = std::hypot(i * hx + x, j * hy + y);
          rest += rho < range ? value(pad_z0, rho) : -1 / rho;
        }
      rest /= static_cast<double>(places_x.size() * places_y.size());
      zz(i, j) = more * (corner(i + 1, j + 1) - corner(i, j + 1) - corner(i + 1, j) + corner(i, j)) + hx * hy * rest;
    }
  return thickness * (1 - poisson_ * poisson_) / pi * zz;
}

CellInfluence PadLayer::influence(double thickness, double hx, double hy, double x, double y) const {
  CellInfluence sum = with_rest(thickness, hx / thickness, hy / thickness, x / thickness, y / thickness,
                                half_space_of(hx / thickness, hy / thickness, x / thickness, y / thickness));
  if (object_.softness > 0) sum += object_.influence(hx, hy, x, y);
  return sum;
}

/// Of cells of uniform traction, sides over H, for offsets of 0 to nx and ny cells.
std::vector<CellInfluence> PadLayer::uniform_influences(double thickness, double hx, double hy, int nx, int ny) const {
  const std::vector<Eigen::Array<double, 5, 1>> half = half_spaces(hx, hy, nx, ny);
  std::vector<CellInfluence> all;
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j) all.push_back(with_rest(thickness, hx, hy, i * hx, j * hy, half[i * (ny + 1) + j]));
  return all;
}

namespace {

/// Influence of cells of shares(), sides over H, by that of uniform parts as far as `range`: uniform(sides of a part,
/// offsets of 0 to nx and ny parts).
template <class Uniform>
std::vector<CellInfluence> of_parts(double hx, double hy, int n, double range, const Uniform& uniform) {
  const std::vector<PadLayer::Share> along_x = PadLayer::shares(hx), along_y = PadLayer::shares(hy);
  const int mx = PadLayer::parts(hx), my = PadLayer::parts(hy);
  if (mx == 1 && my == 1) return uniform(hx, hy, n, n);
  const auto reach = [n, range](double side, int parts) {
    return static_cast<int>(std::min(n * parts + 5.0 * parts / 2, std::floor(range * parts / side) + 1));
  };
  const int nx = reach(hx, mx), ny = reach(hy, my);
  const std::vector<CellInfluence> fine = uniform(hx / mx, hy / my, nx, ny);
  // Sums along x, then along y. On the other side of the source the parts that are odd change their sign.
  const auto add = [](CellInfluence& to, double w, double odd_x, double odd_y, const CellInfluence& c) {
    to.zz += w * c.zz, to.xx += w * c.xx, to.yy += w * c.yy;
    to.xy += w * odd_x * odd_y * c.xy, to.xz += w * odd_x * c.xz, to.yz += w * odd_y * c.yz;
  };
  std::vector<CellInfluence> lines((n + 1) * (ny + 1)), all((n + 1) * (n + 1));
  for (int i = 0; i <= n; ++i)
    for (const auto& [place, share] : along_x) {
      const int at = i * mx + static_cast<int>(std::lround(place * mx));
      if (std::abs(at) > nx) continue;
      for (int j = 0; j <= ny; ++j)
        add(lines[i * (ny + 1) + j], share * mx, at < 0 ? -1 : 1, 1, fine[std::abs(at) * (ny + 1) + j]);
    }
  for (int j = 0; j <= n; ++j)
    for (const auto& [place, share] : along_y) {
      const int at = j * my + static_cast<int>(std::lround(place * my));
      if (std::abs(at) > ny) continue;
      for (int i = 0; i <= n; ++i)
        add(all[i * (n + 1) + j], share * my, 1, at < 0 ? -1 : 1, lines[i * (ny + 1) + std::abs(at)]);
    }
  return all;
}

}  // namespace

std::vector<CellInfluence> PadLayer::influences(double thickness, double hx, double hy, int n) const {
  const double unit = thickness * soft_thickness_;
  std::vector<CellInfluence> all =
      of_parts(hx / unit, hy / unit, n, reach_ / soft_thickness_, [&](double side_x, double side_y, int nx, int ny) {
        return uniform_influences(thickness, side_x * soft_thickness_, side_y * soft_thickness_, nx, ny);
      });
  if (!(object_.softness > 0)) return all;
  const std::vector<CellInfluence> more = object_.influences(thickness, hx, hy, n);
  for (std::size_t k = 0; k < all.size(); ++k) all[k] += more[k];
  return all;
}

CellInfluence& CellInfluence::operator+=(const CellInfluence& other) {
  zz += other.zz, xx += other.xx, yy += other.yy, xy += other.xy, xz += other.xz, yz += other.yz;
  return *this;
}

CellInfluence SoftObject::influence(double hx, double hy, double x, double y) const {
  return influence_of(*this, half_space_of(hx, hy, x, y));
}

/// Five parts of a wide side are enough for a half-space, in which no length is small.
std::vector<CellInfluence> SoftObject::influences(double thickness, double hx, double hy, int n) const {
  const double x = std::min(hx / thickness, 2.0), y = std::min(hy / thickness, 2.0);
  const auto uniform = [&](double side_x, double side_y, int nx, int ny) {
    std::vector<CellInfluence> all;
    for (const auto& half : half_spaces(side_x / x * hx, side_y / y * hy, nx, ny))
      all.push_back(influence_of(*this, half));
    return all;
  };
  return of_parts(x, y, n, std::numeric_limits<double>::infinity(), uniform);
}

PadLayer PadLayer::beside(const SoftObject& object) const {
  PadLayer layer = *this;
  layer.object_ = object;
  return layer;
}

/// Lengths are over H.
CellInfluence PadLayer::with_rest(double thickness, double hx, double hy, double x, double y,
                                  const Eigen::Array<double, 5, 1>& half_space) const {
  double z0 = 0, A = 0, B_cos = 0, B_sin = 0, Zx = 0, Zy = 0;
  over_cell(hx, hy, x, y, near_, [&](double X, double Y, double weight) {
    const double rho = std::sqrt(X * X + Y * Y), cosine = rho > 0 ? X / rho : 1, sine = rho > 0 ? Y / rho : 0;
    const Eigen::Array4d at = weight * displacements(rho);
    z0 += at[pad_z0];
    A += at[pad_A];
    B_cos += at[pad_B] * (cosine * cosine - sine * sine);
    B_sin += at[pad_B] * 2 * sine * cosine;
    Zx += at[pad_Z] * cosine;
    Zy += at[pad_Z] * sine;
  });
  const double nu = poisson_, cell = hx * hy;
  const double Ixx = half_space[0], Iyy = half_space[1], Ixy = half_space[2], Ix = half_space[3], Iy = half_space[4];
  const double c = thickness * (1 + nu) / pi;
  return {.zz = c * (1 - nu) * (Ixx + Iyy + cell * z0),
          .xx = c * (Ixx + (1 - nu) * Iyy + cell / 2 * (A - B_cos)),
          .yy = c * ((1 - nu) * Ixx + Iyy + cell / 2 * (A + B_cos)),
          .xy = c * (nu * Ixy - cell / 2 * B_sin),
          .xz = c / 2 * ((1 - 2 * nu) * Ix + cell * Zx),
          .yz = c / 2 * ((1 - 2 * nu) * Iy + cell * Zy)};
}

PadBaseStress PadLayer::base_stress(double thickness, double hx, double hy, double x, double y) const {
  hx /= thickness, hy /= thickness, x /= thickness, y /= thickness;
  const double unit_x = hx / soft_thickness_, unit_y = hy / soft_thickness_;
  const std::vector<Share> along_x = shares(unit_x), along_y = shares(unit_y);
  const int mx = parts(unit_x), my = parts(unit_y);
  PadBaseStress sum = PadBaseStress::Zero();
  for (const auto& [px, share_x] : along_x) {
    if (std::abs(x - px * hx) > reach_ + hx / mx) continue;
    for (const auto& [py, share_y] : along_y) {
      if (std::abs(y - py * hy) > reach_ + hy / my) continue;
      over_cell(hx / mx, hy / my, x - px * hx, y - py * hy, base_near * deep_,
                [&, share = share_x * share_y](double X, double Y, double w) {
                  const double rho = std::hypot(X, Y), cosine = rho > 0 ? X / rho : 1, sine = rho > 0 ? Y / rho : 0;
                  const Eigen::Array<double, 5, 1> b = share * w * stresses(rho);
                  const double b0 = b[0], bA = b[1], even = b[2] * (cosine * cosine - sine * sine),
                               odd = b[2] * 2 * sine * cosine;
                  const double bxz = b[3], bzx = b[4];
                  PadBaseStress at;
                  at << -cosine * bzx, -sine * bzx, b0,  //
                      bA - even, -odd, -cosine * bxz,    //
                      -odd, bA + even, -sine * bxz;
                  sum += at;
                });
    }
  }
  return hx * hy / (2 * pi) * sum;
}

std::vector<PadBaseStress> PadLayer::base_stresses(double thickness, double hx, double hy, int n, double x,
                                                   double y) const {
  return of_cells(hx / thickness, hy / thickness, soft_thickness_, n, x / thickness, y / thickness, reach_,
                  [this](double side_x, double side_y, double at_x, double at_y) {
                    return base_stress(1, side_x, side_y, at_x, at_y);
                  });
}

std::vector<PadBaseStress> PadLayer::of_cells(double hx, double hy, double unit, int n, double x, double y,
                                              double reach, const OfPart& of_part) {
  const double unit_x = hx / unit, unit_y = hy / unit;
  const std::vector<Share> along_x = shares(unit_x), along_y = shares(unit_y);
  const int mx = parts(unit_x), my = parts(unit_y);
  // Part u lies u times its side from the middle of the first cell; those out of range give nothing.
  struct Parts {
    Parts(double at, double side, int parts, int cells, double range) {
      const int least = -5 * parts / 2, most = (cells - 1) * parts - least;
      first = static_cast<int>(std::clamp<double>(std::floor((at - range) / side), least, most));
      end = static_cast<int>(std::clamp<double>(std::ceil((at + range) / side), least, most)) + 1;
    }
    int first, end;
  };
  const Parts u(x, hx / mx, mx, n, reach), v(y, hy / my, my, n, reach);
  std::vector<PadBaseStress> lines(n * std::max(0, v.end - v.first), PadBaseStress::Zero()),
      all(n * n, PadBaseStress::Zero());
  const auto line = [&](int i, int l) -> PadBaseStress& { return lines[i * (v.end - v.first) + l - v.first]; };
  const auto share_of = [](const std::vector<Share>& shares, int part) {
    const int last = static_cast<int>(shares.size()) / 2;
    return std::abs(part) <= last ? shares[part + last].share : 0;
  };
  for (int k = u.first; k < u.end; ++k)
    for (int l = v.first; l < v.end; ++l) {
      const PadBaseStress part =
          static_cast<double>(mx * my) * of_part(hx / mx, hy / my, x - k * hx / mx, y - l * hy / my);
      for (int i = 0; i < n; ++i)
        if (const double share = share_of(along_x, k - i * mx); share != 0) line(i, l) += share * part;
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int l = v.first; l < v.end; ++l) all[i * n + j] += share_of(along_y, l - j * my) * line(i, l);
  return all;
}

}  // namespace tactel::fem
