// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_step_blocks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/shared/pad_layout.h"
#include "kernels/shared/pad_step_layout.h"

namespace tactel::host {
namespace {

constexpr double most_asymmetry = 1e-4;  ///< of a cell on itself, as tables of sides are right to
// Over the geometric mean of the extreme eigenvalues of B, of n and of t: fewest iterations to one error, for cells of
// 0.1 to 0.9 H and nu of 0.1 to 0.4999 (docs/notebook/2026-11-29-splitting.md).
constexpr double normal_rho = 1.1, tangential_rho = 1.55;

/// What the tractions n, t_x, t_y of a cell do to the surface of another, as the kernel takes them.
class Influence {
 public:
  Influence(const std::vector<double>& table, bool pairs, int nx, int ny)
      : table_(table), pairs_(pairs), nx_(nx), ny_(ny) {}

  int nx() const { return nx_; }
  int ny() const { return ny_; }

  /// Displacement `to` of cell (ix, iy) by traction `by` on cell (jx, jy).
  double operator()(int to, int ix, int iy, int by, int jx, int jy) const {
    constexpr int of_pairs[3][3] = {
        {PAD_ZZ, PAD_PAIR_ZX, PAD_PAIR_ZY}, {PAD_XZ, PAD_XX, PAD_XY}, {PAD_YZ, PAD_PAIR_YX, PAD_YY}};
    constexpr int of_layer[3][3] = {{PAD_ZZ, PAD_XZ, PAD_YZ}, {PAD_XZ, PAD_XX, PAD_XY}, {PAD_YZ, PAD_XY, PAD_YY}};
    const int entry = pairs_ ? PAD_PAIR * ((ix * ny_ + iy) * nx_ * ny_ + jx * ny_ + jy)
                             : PAD_INFLUENCE * ((jx - ix + nx_) * (2 * ny_ + 1) + jy - iy + ny_);
    const int at = PAD_TABLE_HEAD + entry + (pairs_ ? of_pairs : of_layer)[to][by];
    const double number = table_[static_cast<std::size_t>(at)];
    return to > 0 && by == 0 ? -number : number;  // n is the negative of a force along z
  }

 private:
  const std::vector<double>& table_;
  bool pairs_;
  int nx_, ny_;
};

/// The sign of a part (n, t_x, t_y) in an image along x or y.
int sign(int part, bool along_y) { return part == (along_y ? 2 : 1) ? -1 : 1; }

bool is_its_own_image(const Influence& influence) {
  const int nx = influence.nx(), ny = influence.ny();
  for (int to = 0; to < 3; ++to)
    for (int by = 0; by < 3; ++by)
      for (int i = 0; i < nx * ny; ++i)
        for (int j = 0; j < nx * ny; ++j) {
          const int ix = i / ny, iy = i % ny, jx = j / ny, jy = j % ny;
          const double own = influence(to, ix, iy, by, jx, jy);
          const double x = influence(to, nx - 1 - ix, iy, by, nx - 1 - jx, jy) * sign(to, false) * sign(by, false),
                       y = influence(to, ix, ny - 1 - iy, by, jx, ny - 1 - jy) * sign(to, true) * sign(by, true);
          if (!(std::abs(x - own) <= most_asymmetry && std::abs(y - own) <= most_asymmetry)) return false;
        }
  return true;
}

/// Of fields whose n is odd along x or y. Where a field is odd across a middle line of cells it is 0 there: rows and
/// columns are those of the unit matrix.
Eigen::MatrixXd block_of(const Influence& influence, bool odd_x, bool odd_y) {
  const int nx = influence.nx(), ny = influence.ny(), half_x = (nx + 1) / 2, half_y = (ny + 1) / 2,
            quarter = half_x * half_y;
  const auto vanishes = [&](int part, int x, int y) {
    return (odd_x != (part == 1) && 2 * x == nx - 1) || (odd_y != (part == 2) && 2 * y == ny - 1);
  };
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(3 * quarter, 3 * quarter);
  for (int row = 0; row < 3 * quarter; ++row)
    for (int column = 0; column < 3 * quarter; ++column) {
      const int to = row / quarter, ix = row % quarter / half_y, iy = row % half_y, by = column / quarter,
                jx = column % quarter / half_y, jy = column % half_y;
      if (vanishes(to, ix, iy) || vanishes(by, jx, jy)) {
        block(row, column) = row == column;
        continue;
      }
      const int x_sign = odd_x != (by == 1) ? -1 : 1, y_sign = odd_y != (by == 2) ? -1 : 1;
      for (int image = 0; image < 4; ++image) {
        const bool across = (image & 1) != 0, along = (image & 2) != 0;
        if ((across && 2 * jx == nx - 1) || (along && 2 * jy == ny - 1)) continue;
        block(row, column) += (across ? x_sign : 1) * (along ? y_sign : 1) *
                              influence(to, ix, iy, by, across ? nx - 1 - jx : jx, along ? ny - 1 - jy : jy);
      }
    }
  return block;
}

/// The smallest and the largest eigenvalue of some matrices that are symmetric but for middle lines.
struct Extremes {
  double least = std::numeric_limits<double>::infinity(), most = 0;

  void take(const Eigen::MatrixXd& matrix) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (matrix + matrix.transpose()),
                                                                Eigen::EigenvaluesOnly);
    least = std::min(least, solver.eigenvalues().minCoeff()), most = std::max(most, solver.eigenvalues().maxCoeff());
  }
  double mean() const { return std::sqrt(std::max(least, 1e-3 * most) * most); }
};

}  // namespace

SplitBlocks split_blocks(const std::vector<double>& table, bool pairs, int nx, int ny) {
  const Influence influence(table, pairs, nx, ny);
  SplitBlocks made;
  if (!is_its_own_image(influence)) return made;
  const int quarter = (nx + 1) / 2 * ((ny + 1) / 2), rows = 3 * quarter, rounds = (rows + STEP_ROUND - 1) / STEP_ROUND;
  std::vector<Eigen::MatrixXd> blocks;
  Extremes normal, tangential;
  for (const bool odd_x : {false, true})
    for (const bool odd_y : {false, true}) {
      blocks.push_back(block_of(influence, odd_x, odd_y));
      normal.take(blocks.back().topLeftCorner(quarter, quarter));
      tangential.take(blocks.back().bottomRightCorner(2 * quarter, 2 * quarter));
    }
  made.rho_n = normal_rho * normal.mean(), made.rho_t = tangential_rho * tangential.mean();
  Eigen::VectorXd rho = Eigen::VectorXd::Constant(rows, made.rho_t);
  rho.head(quarter).setConstant(made.rho_n);
  const int numbers = 4 * rounds * rows * STEP_ROUND;
  made.numbers.resize(2 * static_cast<std::size_t>(numbers));
  for (int k = 0; k < 4; ++k) {
    const Eigen::MatrixXd& B = blocks[static_cast<std::size_t>(k)];
    const Eigen::MatrixXd inverse = (B + Eigen::MatrixXd(rho.asDiagonal())).inverse();
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < rows; ++column) {
        const int at = ((k * rounds + row / STEP_ROUND) * rows + column) * STEP_ROUND + row % STEP_ROUND,
                  behind = numbers + at;
        made.numbers[static_cast<std::size_t>(at)] = B(row, column);
        made.numbers[static_cast<std::size_t>(behind)] = inverse(row, column);
      }
  }
  return made;
}

}  // namespace tactel::host
