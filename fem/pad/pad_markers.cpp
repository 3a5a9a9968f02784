// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_markers.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/layer/legendre_points.h"
#include "fem/numbers/angles.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/bessel.h"
#include "fem/pad/pad_search.h"
#include "fem/pad/side_kernel.h"

namespace tactel::fem {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int steps_a_thickness = 80;  ///< of the rest's cubics: they leave 1e-8 of it
constexpr double reach = 24;           ///< H: beyond, the layer does not move
constexpr std::size_t most_markers = 4096;

/// Transforms times G k, without their Bessel functions.
struct Transforms {
  double Wz, Uz, Wx, Ux, across;
};

Transforms of_layer(double nu, double a, double z) {
  // Hyperbolic functions of a over e^a, of s over e^s, D over e^2a.
  const double K = 3 - 4 * nu, s = a * z, e2a = std::exp(-2 * a), fall = std::exp(s - a);
  const double ca = (1 + e2a) / 2, sa = -std::expm1(-2 * a) / 2;
  const double cs = (1 + std::exp(-2 * s)) / 2, ss = -std::expm1(-2 * s) / 2;
  const double D = 2 * (K * ca * ca + (a * a + (1 - 2 * nu) * (1 - 2 * nu)) * e2a);
  const auto W = [&](double p, double q) { return fall / D * (p * (K * ss - s * cs) - q * s * ss); };
  const auto U = [&](double p, double q) { return -fall / D * (p * s * ss + q * (K * ss + s * cs)); };
  const double pz = 2 * (1 - nu) * ca + a * sa, qz = (1 - 2 * nu) * sa - a * ca;
  const double px = -((1 - 2 * nu) * sa + a * ca), qx = -(2 * (1 - nu) * ca - a * sa);
  return {W(pz, qz), U(pz, qz), W(px, qx), U(px, qx), fall * ss / ca};
}

Transforms of_half_space(double nu, double d) {
  const double e = std::exp(-d);
  return {e * (1 - nu + d / 2), -e * (1 - 2 * nu - d) / 2, -e * (1 - 2 * nu + d) / 2, e * (1 - nu - d / 2), e};
}

/// Displacement in a half-space at depth d by uniform tractions on a cell: integrals over a quadrant up to a corner,
/// whose logarithms are asinh where what is left cancels between corners.
Eigen::Matrix3d by_cell(double nu, double d, double hx, double hy, double x, double y) {
  constexpr double least = 1e-300;
  const double c = (1 + nu) / (2 * pi), m = 1 - 2 * nu;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const int side_x : {-1, 1})
    for (const int side_y : {-1, 1}) {
      const double X = x + side_x * hx / 2, Y = y + side_y * hy / 2, R = std::sqrt(X * X + Y * Y + d * d);
      const double lx = std::asinh(X / std::max(std::hypot(Y, d), least));
      const double ly = std::asinh(Y / std::max(std::hypot(X, d), least));
      const double lR = std::log(std::max(R + d, least));
      const double t = d > 0 ? d * std::atan2(X * Y, d * R) : 0;
      // Of x / (R (R + d)) and y / (R (R + d)): along X and Y.
      const auto arcs = [&](double u, double v) { return u != 0 ? std::atan(v / u) - std::atan(d * v / (u * R)) : 0; };
      const double ax = arcs(X, Y), ay = arcs(Y, X);
      const double Ix = Y * lR + d * ly + X * ax, Iy = X * lR + d * lx + Y * ay;
      const double Kx = X * ly - d * ax, Ky = Y * lx - d * ay;
      const double I = X * ly + Y * lx - t;
      Eigen::Matrix3d at;
      at << I + Y * lx - t + m * Kx, -R + m * (R - d * lR), m * Ix + d * ly,  //
          -R + m * (R - d * lR), I + X * ly - t + m * Ky, m * Iy + d * lx,    //
          -m * Ix + d * ly, -m * Iy + d * lx, 2 * (1 - nu) * I + t;
      sum += side_x * side_y * at;
    }
  return c * sum;
}

}  // namespace

LayerAtDepth::LayerAtDepth(double poisson, double depth, double farthest, const std::function<void()>& between)
    : poisson_(poisson), depth_(depth) {
  constexpr double first_panel = 1e-5, panel = 0.8, last = 48;  // as of the surface: the rest falls like e^-(1 + z) a
  constexpr int order[parts] = {0, 1, 1, 0, 2};
  std::vector<double> a;
  std::vector<Rest> weight;
  for (const auto& [wave, share] : points_on_doubling_panels(first_panel, panel, last, 16)) {
    const Transforms t = of_layer(poisson, wave, 1 - depth), h = of_half_space(poisson, wave * depth);
    const double along = t.Ux - h.Ux, across = t.across - h.across;
    Rest rest;
    rest << t.Wz - h.Wz, -(t.Uz - h.Uz), t.Wx - h.Wx, (along + across) / 2, (along - across) / 2;
    a.push_back(wave), weight.push_back((1 + poisson) / pi * share * rest);
  }
  const auto steps = static_cast<int>(std::min(farthest, reach) * steps_a_thickness) + 2;
  for (int k = 0; k <= steps; ++k) {
    between();
    Rest value = Rest::Zero(), slope = Rest::Zero();
    for (std::size_t w = 0; w < a.size(); ++w) {
      const Bessel J(a[w] * k / steps_a_thickness);
      for (int f = 0; f < parts; ++f) {
        value[f] += weight[w][f] * J.value[order[f]];
        slope[f] += weight[w][f] * J.slope[order[f]] * a[w] / steps_a_thickness;
      }
    }
    value_.push_back(value), slope_.push_back(slope);
  }
}

LayerAtDepth::Rest LayerAtDepth::rest(double rho) const {
  const double place = std::min(rho * steps_a_thickness, static_cast<double>(value_.size() - 1));
  const auto k = std::min(static_cast<std::size_t>(place), value_.size() - 2);
  const double q = place - static_cast<double>(k);
  const Rest rise = value_[k + 1] - value_[k];
  return value_[k] +
         q * (slope_[k] + q * (3 * rise - 2 * slope_[k] - slope_[k + 1] + q * (slope_[k] + slope_[k + 1] - 2 * rise)));
}

Eigen::Matrix3d LayerAtDepth::displacement(double hx, double hy, double x, double y) const {
  static const std::vector<LegendrePoint> points = legendre_points(4);
  Eigen::Matrix3d sum = by_cell(poisson_, depth_, hx, hy, x, y);
  for (const LegendrePoint& p : points)
    for (const LegendrePoint& q : points) {
      const double X = x - hx / 2 * p.x, Y = y - hy / 2 * q.x, rho = std::hypot(X, Y);
      const double cosine = rho > 0 ? X / rho : 1, sine = rho > 0 ? Y / rho : 0;
      const Rest f = rest(rho);
      const double even = f[B] * (cosine * cosine - sine * sine), odd = f[B] * 2 * sine * cosine;
      Eigen::Matrix3d at;
      at << f[A] - even, -odd, f[xz] * cosine,  //
          -odd, f[A] + even, f[xz] * sine,      //
          f[zx] * cosine, f[zx] * sine, f[zz];
      sum += p.weight * q.weight / 4 * hx * hy * at;
    }
  return sum;
}

std::vector<std::array<double, 2>> marker_places(const Markers& markers) {
  if (!markers.places.empty()) return markers.places;
  const auto [columns, rows] = markers.counts;
  std::vector<std::array<double, 2>> places;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      places.push_back(
          {(column - (columns - 1) / 2.0) * markers.pitch[0], (row - (rows - 1) / 2.0) * markers.pitch[1]});
  return places;
}

std::size_t marker_count(const std::optional<Markers>& markers) {
  if (!markers) return 0;
  return markers->places.empty()
             ? static_cast<std::size_t>(markers->counts[0]) * static_cast<std::size_t>(markers->counts[1])
             : markers->places.size();
}

void validate(const Markers& markers, const PadSensor& sensor) {
  if (!side_rules(sensor).knows_inside)
    throw ValueError("markers", "of a pad with free sides", "left out; or sensor.sides = \"held\"");
  if (!sensor.layers.empty()) throw ValueError("markers", "beside sensor.layers", "left out: they lie in one layer");
  require(markers.depth >= 0 && markers.depth < sensor.thickness, "markers.depth", markers.depth,
          "mm below the surface, 0 or more and less than sensor.thickness");
  for (const int count : markers.counts)
    require(count >= 1 && count <= 1000, "markers.counts", count, "numbers of markers along x and y, 1 or more each");
  for (const double p : markers.pitch) check_length("markers.pitch", p);
  const std::size_t count = marker_count(markers);
  require(count <= most_markers, markers.places.empty() ? "markers.counts" : "markers.places",
          static_cast<double>(count), "4096 markers at most");
  for (const auto& [x, y] : markers.places) {
    require(std::abs(x) <= 1e6, "markers.places", x, "places in mm, at most 1e6 from the middle");
    require(std::abs(y) <= 1e6, "markers.places", y, "places in mm, at most 1e6 from the middle");
  }
}

void validate(const Camera& camera) {
  check_length("camera.distance", camera.distance);
  check_length("camera.pixels_per_mm", camera.pixels_per_mm, "a number between 1e-6 and 1e6");
  for (const double pixel : camera.centre)
    require(std::abs(pixel) <= 1e6, "camera.centre", pixel, "two pixels, -1e6 to 1e6");
  require(camera.noise_px >= 0 && camera.noise_px <= 1e6, "camera.noise_px", camera.noise_px, "pixels, 0 to 1e6");
}

Eigen::MatrixXd marker_rows(const Markers& markers, const PadScene& scene, const PadCells& cells,
                            const std::function<void()>& between) {
  const PadSensor& sensor = scene.sensor;
  const double H = sensor.thickness;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(radians(cells.frame(scene.indenter))).toRotationMatrix();
  const Eigen::Vector2d axis(scene.indenter.position[0], scene.indenter.position[1]), first(cells.x(0), cells.y(0));
  std::vector<Eigen::Vector2d> own;  // from the first cell
  double farthest = 0;
  for (const auto& [x, y] : marker_places(markers)) {
    own.emplace_back(turn.transpose() * (Eigen::Vector2d(x, y) - axis) - first);
    farthest = std::max(farthest, own.back().norm() + 2 * std::numbers::sqrt2 * cells.half_size());
  }
  constexpr double spread = 4;  // sides that the smooth traction of a wide cell covers, and more
  const LayerAtDepth layer(sensor.poisson, markers.depth / H, farthest / H + spread * std::max(cells.hx, cells.hy) / H,
                           between);
  const PadLayer::OfPart of_part = [&](double hx, double hy, double x, double y) {
    return std::hypot(x, y) < reach ? layer.displacement(hx, hy, x, y) : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
  };
  const int ny = cells.ny(), n = std::max(cells.n, ny), count = cells.count();
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned.topLeftCorner<2, 2>() = turn;
  const double scale = H / sensor.young;
  Eigen::MatrixXd rows(3 * own.size(), 3 * count);
  for (std::size_t k = 0; k < own.size(); ++k) {
    between();
    const auto all = PadLayer::of_cells(cells.hx / H, cells.hy / H, 1, n, own[k][0] / H, own[k][1] / H, reach, of_part);
    for (int i = 0; i < count; ++i) {
      const Eigen::Matrix3d at = scale * (turned * all[i / ny * n + i % ny] * turned.transpose());
      auto to = rows.middleRows<3>(static_cast<Eigen::Index>(3 * k));
      to.col(i) = -at.col(2);  // pressure is the negative of f_z
      to.col(count + i) = at.col(0), to.col(2 * count + i) = at.col(1);
    }
  }
  return rows;
}

Eigen::MatrixX2d pixels_of(const Camera& camera, const Markers& markers, const Eigen::MatrixX3d& displacements) {
  const auto places = marker_places(markers);
  Eigen::MatrixX2d pixels(displacements.rows(), 2);
  for (Eigen::Index k = 0; k < pixels.rows(); ++k)
    for (const int axis : {0, 1}) {
      const double at = places[k % places.size()][axis];
      pixels(k, axis) = camera.centre[axis] + camera.pixels_per_mm * (at + displacements(k, axis) -
                                                                      at * displacements(k, 2) / camera.distance);
    }
  return pixels;
}

void see_markers(const PadScene& scene, PadSolution& solution, const std::function<void()>& between) {
  if (!scene.markers) return;
  const PadCells& cells = solution.cells;
  PadScene seen = scene;
  seen.indenter = aligned(scene.indenter, scene.sensor);  // as the cells have it
  Eigen::MatrixXd rows;
  for (PadStep& step : solution.steps) {
    if (step.markers.rows() == 0) {  // else by the kernel, or on cells of the step alone
      if (rows.size() == 0) rows = marker_rows(*scene.markers, seen, cells, between);
      Eigen::VectorXd tractions(3 * cells.count());
      if (step.straining.size() > 0)
        tractions = step.straining.reshaped();
      else
        tractions << step.normal_force, step.tangential_force.col(0), step.tangential_force.col(1);
      step.markers = (rows * tractions / cells.area()).reshaped(3, rows.rows() / 3).transpose();
    }
    if (scene.camera) step.pixels = pixels_of(*scene.camera, *scene.markers, step.markers);
  }
}

}  // namespace tactel::fem
