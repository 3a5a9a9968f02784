// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/endless_bricks.h"

#include <cmath>
#include <complex>
#include <numbers>

namespace tactel::fem {
namespace {

using std::numbers::pi;

/// Whether a component of a response is odd along x, or y: (displacement or force, traction), x, y, z each.
bool odd_in_x(int to, int by) { return (to == 0) != (by == 0); }
bool odd_in_y(int to, int by) { return (to == 1) != (by == 1); }

/// Cosines and sines of waves exp(i (a x + b y)) between nodes that lie -1 to 1 bricks apart, [3 along x + along y].
struct Phases {
  std::array<double, 9> cosine, sine;

  Phases(double a, double b) {
    for (int k = 0; k < 9; ++k) {
      const int along = k / 3 - 1, across = k % 3 - 1;
      const double phase = a * along + b * across;
      cosine[k] = std::cos(phase), sine[k] = std::sin(phase);
    }
  }
};

/// The bricks of one layer under waves of the nodes: real where u_z and f_z stand for -i times theirs. [upper,
/// component][upper, component] with the lower level first.
Eigen::Matrix<double, 6, 6> symbol(const BrickMatrix& brick, const Phases& phases) {
  Eigen::Matrix<double, 6, 6> sum = Eigen::Matrix<double, 6, 6>::Zero();
  for (int row = 0; row < 24; ++row)
    for (int column = 0; column < 24; ++column) {
      const int k = 3 * (column / 12 - row / 12 + 1) + column / 6 % 2 - row / 6 % 2 + 1, to = row % 6, by = column % 6;
      // i^-1 and i of the two sides leave the sine where one component is along z.
      const double wave = (to % 3 == 2) == (by % 3 == 2) ? phases.cosine[k]
                          : by % 3 == 2                  ? -phases.sine[k]
                                                         : phases.sine[k];
      sum(to, by) += wave * brick(row, column);
    }
  return sum;
}

/// Sum over a cell's nodes of their weights and waves about its middle.
double hat(int along, double a) {
  double sum = 0;
  for (int k = 0; k <= along; ++k) sum += (k == 0 || k == along ? 0.5 : 1) * std::cos(a * (k - along / 2.0));
  return sum;
}

/// Cosines or sines of the wave numbers 2 pi k / period, 0 <= k <= period / 2, at places in bricks, [places][waves],
/// each with the share of k and -k in the mean over all waves.
Eigen::MatrixXd waves(bool odd, const Eigen::ArrayXd& places, int period) {
  Eigen::MatrixXd w(places.size(), period / 2 + 1);
  for (int k = 0; k <= period / 2; ++k) {
    const double share = (k == 0 || 2 * k == period ? 1.0 : 2.0) / period;
    const Eigen::ArrayXd phase = 2 * pi * k / period * places;
    const Eigen::ArrayXd wave = odd ? Eigen::ArrayXd(phase.sin()) : Eigen::ArrayXd(phase.cos());
    w.col(k) = share * wave;
  }
  return w;
}

/// Displacements of the surface by forces on each node of it.
Eigen::Matrix3d solve_waves(const std::vector<BrickMatrix>& layers, double a, double b) {
  const auto count = static_cast<Eigen::Index>(layers.size());
  const Phases phases(a, b);
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(3 * count, 3 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Matrix<double, 6, 6> layer = symbol(layers[k], phases);
    if (k == 0)
      stiffness.topLeftCorner<3, 3>() += layer.bottomRightCorner<3, 3>();
    else
      stiffness.block<6, 6>(3 * (k - 1), 3 * (k - 1)) += layer;
  }
  Eigen::MatrixXd top = Eigen::MatrixXd::Zero(3 * count, 3);
  top.bottomRows<3>().setIdentity();
  return stiffness.llt().solve(top).bottomRows<3>();
}

}  // namespace

EndlessResponse endless_bricks(const BrickMesh& mesh, double poisson, const std::array<int, 2>& period,
                               const std::function<void()>& between) {
  std::vector<BrickMatrix> layers;
  layers.reserve(mesh.layers());
  for (int k = 0; k < mesh.layers(); ++k)
    layers.push_back(brick_stiffness(mesh.dx(), mesh.dy(), mesh.levels[k + 1] - mesh.levels[k], poisson));
  const int count_x = period[0] / 2 + 1, count_y = period[1] / 2 + 1;
  std::array<Eigen::MatrixXd, 9> surface;  // [waves along x][waves along y], of 3 to + by
  for (Eigen::MatrixXd& m : surface) m.resize(count_x, count_y);
  const bool square = mesh.hx == mesh.hy && count_x == count_y;
  constexpr std::array other{1, 0, 2};
  for (int p = 0; p < count_x; ++p) {
    between();
    for (int q = 0; q < count_y; ++q) {
      if (square && q < p) {  // (q, p), mirrored
        for (int c = 0; c < 9; ++c) {
          const int mirrored = 3 * other[c / 3] + other[c % 3];
          surface[c](p, q) = surface[mirrored](q, p);
        }
        continue;
      }
      const double a = 2 * pi * p / period[0], b = 2 * pi * q / period[1];
      const double load = mesh.dx() * mesh.dy() * hat(mesh.along, a) * hat(mesh.along, b);
      const double mean = hat(mesh.along, a) * hat(mesh.along, b) / (mesh.along * mesh.along);
      const Eigen::Matrix3d response = solve_waves(layers, a, b);
      for (int c = 0; c < 9; ++c) surface[c](p, q) = load * mean * response(c / 3, c % 3);
    }
  }
  // Back to places. The wave of an odd component is i sin; of the z components above, u_x = i sin(..) (i f_z).
  EndlessResponse out;
  const auto at_places = [&](const Eigen::MatrixXd& of, int c, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
    const int to = c / 3, by = c % 3;
    const bool ox = odd_in_x(to, by), oy = odd_in_y(to, by);
    const double sign = ox && oy ? -1 : by == 2 && to != 2 ? 1 : to == 2 && by != 2 ? -1 : 1;
    return Eigen::MatrixXd(sign * waves(ox, x, period[0]) * of * waves(oy, y, period[1]).transpose());
  };
  const auto steps = [](int n, double first, double step) {
    return Eigen::ArrayXd(first + step * Eigen::ArrayXd::LinSpaced(n, 0, n - 1));
  };
  const Eigen::ArrayXd cells_x = steps(mesh.nx, 0, mesh.along), cells_y = steps(mesh.ny, 0, mesh.along);
  constexpr std::array components{8, 0, 4, 1, 2, 5};  // zz, xx, yy, xy, xz, yz
  for (std::size_t k = 0; k < components.size(); ++k)
    out[k] = at_places(surface[components[k]], components[k], cells_x, cells_y);
  return out;
}

}  // namespace tactel::fem
