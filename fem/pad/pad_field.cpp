// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_field.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "fem/numbers/value_error.h"
#include "fem/pad/side_kernel.h"

namespace tactel::fem {
namespace {

// A traction f e^(i k x) on the surface, e along k, n across it, s = |k| z, S = |k| H, K = 3 - 4 nu. Along e the
// layer is in plane strain: u_e = i U, u_z = W, where Papkovich and Neuber's solutions that vanish at the base are
//
//     U = -a s sinh s - b (s cosh s + K sinh s)      W = a (K sinh s - s cosh s) - b s sinh s
//
// and with the dilatation 2 (1 - 2 nu) |k| (a cosh s + b sinh s) all stress is finite at nu = 1/2:
//
//     p = 2 nu (a cosh s + b sinh s)    s_ee = 2 G |k| (p - U)    s_nn = 2 G |k| p    s_zz = 2 G |k| (W' + p)
//     t_ez = i G |k| (U' + W)
//
// Across it is in antiplane shear: u_n = f_n sinh s / (G |k| cosh S).

using Complex = std::complex<double>;

constexpr int levels = 13, most_points = 61;
constexpr double repeats = 10;   // thicknesses between a contact and its image
constexpr double margin = 1.5;   // thicknesses of rubber around a contact
constexpr double finest = 0.05;  // thicknesses: a cell counts as no smaller
constexpr double beyond = 40;    // of |k| (H - z): a wave that long has died out

enum { u_x, u_y, u_z, s_xx, s_yy, s_zz, s_xy, s_yz, s_xz, components };

double sinc(double x) { return x == 0 ? 1 : std::sin(x) / x; }

/// exp(s - S) times 2 cosh s exp(-s), 2 sinh s exp(-s): both over exp(S).
struct Hyperbolic {
  Hyperbolic(double s, double S) {
    const double grown = std::exp(s - S), decayed = std::exp(-s - S);
    cosh = (grown + decayed) / 2;
    sinh = (grown - decayed) / 2;
  }
  double cosh, sinh;
};

/// What a wave of traction f, MPa, does at a level. `s` = |k| z, `k` per mm.
struct Wave {
  Wave(double poisson, double shear, double kx, double ky, double thickness, const Eigen::Vector3cd& f)
      : nu(poisson), G(shear), k(std::hypot(kx, ky)), ex(kx / k), ey(ky / k), S(k * thickness) {
    const Hyperbolic top(S, S);
    const double Cz = (2 - 2 * nu) * top.cosh - S * top.sinh, Sz = -(1 - 2 * nu) * top.sinh - S * top.cosh,
                 Ce = (1 - 2 * nu) * top.sinh - S * top.cosh, Se = -(2 - 2 * nu) * top.cosh - S * top.sinh;
    const Complex fz = f[2] / (2 * G * k), fe = Complex(0, -1) * (ex * f[0] + ey * f[1]) / (2 * G * k);
    const double determinant = Cz * Se - Sz * Ce;
    a = (fz * Se - Sz * fe) / determinant;
    b = (Cz * fe - Ce * fz) / determinant;
    n = (ex * f[1] - ey * f[0]) / (G * k * top.cosh);
  }

  void at(double s, Complex* out) const {
    const Hyperbolic h(s, S);
    const double K = 3 - 4 * nu;
    const Complex U = -a * (s * h.sinh) - b * (s * h.cosh + K * h.sinh);
    const Complex W = a * (K * h.sinh - s * h.cosh) - b * (s * h.sinh);
    const Complex dU = -a * (h.sinh + s * h.cosh) - b * ((1 + K) * h.cosh + s * h.sinh);
    const Complex dW = a * ((K - 1) * h.cosh - s * h.sinh) - b * (h.sinh + s * h.cosh);
    const Complex p = 2 * nu * (a * h.cosh + b * h.sinh);
    const Complex i(0, 1), along = i * U, across = n * h.sinh;
    const Complex ee = 2 * G * k * (p - U), nn = 2 * G * k * p, en = i * G * k * across;
    const Complex ez = i * G * k * (dU + W), nz = G * k * n * h.cosh;
    out[u_x] = ex * along - ey * across;
    out[u_y] = ey * along + ex * across;
    out[u_z] = W;
    out[s_xx] = ex * ex * ee + ey * ey * nn - 2 * ex * ey * en;
    out[s_yy] = ey * ey * ee + ex * ex * nn + 2 * ex * ey * en;
    out[s_zz] = 2 * G * k * (dW + p);
    out[s_xy] = ex * ey * (ee - nn) + (ex * ex - ey * ey) * en;
    out[s_xz] = ex * ez - ey * nz;
    out[s_yz] = ey * ez + ex * nz;
  }

  double nu, G, k, ex, ey, S;
  Complex a, b, n;
};

/// The same of an even traction.
void at_rest(double poisson, double shear, const Eigen::Vector3cd& f, double z, Complex* out) {
  const double squeezed = (1 - 2 * poisson) / (2 * shear * (1 - poisson));
  std::fill(out, out + components, 0);
  out[u_x] = f[0] * z / shear;
  out[u_y] = f[1] * z / shear;
  out[u_z] = f[2] * z * squeezed;
  out[s_xx] = out[s_yy] = f[2] * (poisson / (1 - poisson));
  out[s_zz] = f[2];
  out[s_xz] = f[0];
  out[s_yz] = f[1];
}

/// Waves along x or y: numbers, what cells carry of them, and their values at points.
struct Waves {
  Waves(double middle, double side, int n, double half_range, int points, double period, double smallest) {
    const double cell = std::max(side, smallest);
    const int most = static_cast<int>(std::ceil(2 * period / cell));
    k = 2 * std::numbers::pi / period * Eigen::VectorXd::LinSpaced(2 * most + 1, -most, most);
    x = middle + Eigen::VectorXd::LinSpaced(points, -half_range, half_range).array();
    of_cells.resize(k.size(), n);
    at_points.resize(points, k.size());
    for (Eigen::Index m = 0; m < k.size(); ++m) {
      // A cell's uniform traction, and the mean over half a cell.
      const double carried = side / period * sinc(k[m] * side / 2) * sinc(k[m] * cell / 4);
      for (int i = 0; i < n; ++i) of_cells(m, i) = std::polar(carried, -k[m] * (middle + (i - (n - 1) / 2.0) * side));
      for (int i = 0; i < points; ++i) at_points(i, m) = std::polar(1.0, k[m] * x[i]);
    }
  }
  /// The largest wave, counted from the even one, that has not died out so far below the surface.
  Eigen::Index most(double below) const {
    const Eigen::Index all = k.size() / 2;
    const double reached = beyond / (k[all + 1] * std::max(below, 1e-9));
    return reached < static_cast<double>(all) ? static_cast<Eigen::Index>(reached) : all;
  }
  Eigen::VectorXd k, x;
  Eigen::MatrixXcd of_cells, at_points;
};

int points_along(double half_range, double side) {
  return std::clamp(2 * static_cast<int>(std::ceil(half_range / (side / 2))) + 1, 25, most_points);
}

}  // namespace

PadField pad_field(const PadScene& scene, const PadSolution& solution, std::size_t step) {
  if (!side_rules(scene.sensor).knows_inside)
    throw ValueError("sides", "free", "held: the field is that of an endless layer");
  if (!scene.sensor.layers.empty())
    throw ValueError("sensor.layers", std::to_string(scene.sensor.layers.size()) + " layers",
                     "left out: the field is that of one layer");
  const PadCells& cells = solution.cells;
  const PadStep& at = solution.steps.at(step);
  const double H = scene.sensor.thickness, nu = scene.sensor.poisson, G = scene.sensor.young / (2 * (1 + nu));
  const double around = std::min(margin * H, 2 * cells.half_size());
  const double range_x = cells.n * cells.hx / 2 + around, range_y = cells.n * cells.hy / 2 + around;
  const double period = 2 * cells.half_size() + repeats * H;
  const Waves along_x(cells.x_middle, cells.hx, cells.n, range_x, points_along(range_x, cells.hx), period, finest * H);
  const Waves along_y(cells.y_middle, cells.hy, cells.n, range_y, points_along(range_y, cells.hy), period, finest * H);

  const double turned = cells.frame(scene.indenter) * std::numbers::pi / 180;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(turned).toRotationMatrix();
  const Eigen::MatrixX2d shear = at.tangential_force * turn / cells.area();         // in the frame of the cells
  const auto waves_of = [&](const Eigen::VectorXd& traction) -> Eigen::MatrixXcd {  // [waves of y][waves of x]
    return along_y.of_cells * traction.reshaped(cells.n, cells.n).cast<Complex>() * along_x.of_cells.transpose();
  };
  const std::array<Eigen::MatrixXcd, 3> traction{waves_of(shear.col(0)), waves_of(shear.col(1)),
                                                 waves_of(-at.normal_force / cells.area())};

  const auto nx = static_cast<int>(along_x.x.size()), ny = static_cast<int>(along_y.x.size());
  PadField field;
  field.points = {nx, ny, levels};
  const Eigen::Index plane = Eigen::Index(nx) * ny;
  field.place.resize(3, plane * levels);
  field.displacement.resize(3, plane * levels);
  field.stress.resize(6, plane * levels);
  std::vector<Eigen::MatrixXcd> waves(components);
  for (int level = 0; level < levels; ++level) {
    const double below = 1 - static_cast<double>(level) / (levels - 1), z = H * (1 - below * below);
    const Eigen::Index most_x = along_x.most(H - z), most_y = along_y.most(H - z);
    const Eigen::Index first_x = along_x.k.size() / 2 - most_x, first_y = along_y.k.size() / 2 - most_y;
    const Eigen::Index count_x = 2 * most_x + 1, count_y = 2 * most_y + 1;
    for (Eigen::MatrixXcd& of : waves) of.resize(count_y, count_x);
    for (Eigen::Index mx = 0; mx < count_x; ++mx)
      for (Eigen::Index my = 0; my < count_y; ++my) {
        const double kx = along_x.k[first_x + mx], ky = along_y.k[first_y + my], k = std::hypot(kx, ky);
        const auto of = [&](std::size_t part) { return traction[part](first_y + my, first_x + mx); };
        const Eigen::Vector3cd f(of(0), of(1), of(2));
        std::array<Complex, components> out{};
        if (k == 0)
          at_rest(nu, G, f, z, out.data());
        else if (k * (H - z) < beyond)
          Wave(nu, G, kx, ky, H, f).at(k * z, out.data());
        for (int c = 0; c < components; ++c) waves[c](my, mx) = out[static_cast<std::size_t>(c)];
      }
    std::array<Eigen::MatrixXd, components> values;  // [y][x]
    for (int c = 0; c < components; ++c)
      values[c] = (along_y.at_points.middleCols(first_y, count_y) *
                   (waves[c] * along_x.at_points.middleCols(first_x, count_x).transpose()))
                      .real();
    for (int iy = 0; iy < ny; ++iy)
      for (int ix = 0; ix < nx; ++ix) {
        const Eigen::Index i = level * plane + Eigen::Index(iy) * nx + ix;
        const auto value = [&](int c) { return values[c](iy, ix); };
        const Eigen::Vector2d own(along_x.x[ix], along_y.x[iy]);
        field.place.col(i) << turn * own + Eigen::Vector2d(scene.indenter.position[0], scene.indenter.position[1]), z;
        field.displacement.col(i) << turn * Eigen::Vector2d(value(u_x), value(u_y)), value(u_z);
        Eigen::Matrix3d stress;
        stress << value(s_xx), value(s_xy), value(s_xz), value(s_xy), value(s_yy), value(s_yz), value(s_xz),
            value(s_yz), value(s_zz);
        Eigen::Matrix3d around_z = Eigen::Matrix3d::Identity();
        around_z.topLeftCorner<2, 2>() = turn;
        stress = around_z * stress * around_z.transpose();
        field.stress.col(i) << stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(0, 2);
      }
  }
  return field;
}

}  // namespace tactel::fem
