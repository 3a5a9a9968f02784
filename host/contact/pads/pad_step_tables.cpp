// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_step_tables.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_solver.h"
#include "fem/pad/pad_table.h"
#include "host/contact/pads/pad_contact_tables.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/pad_layout.h"
#include "kernels/shared/pad_step_layout.h"

namespace tactel::host {
namespace {

constexpr double most_asymmetry = 1e-4;  ///< of a cell on itself, as tables of sides are right to
// Over the geometric mean of the extreme eigenvalues of B, of n and of t: fewest iterations to one error, for cells of
// 0.1 to 0.9 H and nu of 0.1 to 0.4999 (docs/notebook/2026-11-29-splitting.md).
constexpr double normal_rho = 1.1, tangential_rho = 1.55;

/// Stiffness of a contact of radius a that sticks on the layer, H = E = 1: kt a (1 + a) along it, kr a^3 (1 + a)
/// against a twist. A first guess for the search of a pose: by rigid motions of a disc of cells.
struct StickingDisc {
  double kt, kr;

  StickingDisc(const fem::PadLayer& layer) {
    constexpr int n = 10;
    constexpr double h = 0.14;
    const std::vector<fem::CellInfluence> all = layer.influences(1, h, h, n);
    std::vector<std::array<int, 2>> in;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (std::hypot(i - (n - 1) / 2.0, j - (n - 1) / 2.0) < n / 2.0) in.push_back({i, j});
    const auto count = static_cast<Eigen::Index>(in.size());
    Eigen::MatrixXd C(2 * count, 2 * count), rigid = Eigen::MatrixXd::Zero(2 * count, 2);
    for (Eigen::Index p = 0; p < count; ++p) {
      for (Eigen::Index q = 0; q < count; ++q) {
        const int dx = in[p][0] - in[q][0], dy = in[p][1] - in[q][1];
        const fem::CellInfluence& c =
            all[static_cast<std::size_t>(std::abs(dx)) * (n + 1) + static_cast<std::size_t>(std::abs(dy))];
        C(p, q) = c.xx, C(count + p, count + q) = c.yy;
        C(p, count + q) = C(count + p, q) = dx * dy < 0 ? -c.xy : c.xy;
      }
      rigid(p, 0) = 1;
      rigid(p, 1) = -(in[p][1] - (n - 1) / 2.0) * h, rigid(count + p, 1) = (in[p][0] - (n - 1) / 2.0) * h;
    }
    const Eigen::MatrixXd tractions = C.partialPivLu().solve(rigid);
    const double a = std::sqrt(static_cast<double>(count) * h * h / std::numbers::pi);
    kt = rigid.col(0).dot(tractions.col(0)) * h * h / (a * (1 + a));
    kr = rigid.col(1).dot(tractions.col(1)) * h * h / (a * a * a * (1 + a));
  }
};

/// The kernel's table of pairs, after the head of one of the layer alone. `displacement(place, source, to, by)`: mm.
std::vector<double> table_of_pairs(const std::vector<double>& of_layer, int cells, double thickness,
                                   const auto& displacement) {
  constexpr int x = 0, y = 1, z = 2;
  const double zz = of_layer[PAD_ROOT_ZZ] * of_layer[PAD_ROOT_ZZ], tt = of_layer[PAD_ROOT_TT] * of_layer[PAD_ROOT_TT],
               zt = of_layer[PAD_ROOT_ZZ] * of_layer[PAD_ROOT_TT];
  std::vector<double> table(of_layer.begin(), of_layer.begin() + PAD_TABLE_HEAD);
  for (int place = 0; place < cells; ++place)
    for (int source = 0; source < cells; ++source) {
      const auto number = [&](int to, int by) { return displacement(place, source, to, by) / thickness; };
      double entry[PAD_PAIR] = {};  // n is the negative of a force along z
      entry[PAD_ZZ] = number(z, z) / zz, entry[PAD_XX] = number(x, x) / tt, entry[PAD_YY] = number(y, y) / tt;
      entry[PAD_XY] = number(x, y) / tt, entry[PAD_XZ] = number(x, z) / zt, entry[PAD_YZ] = number(y, z) / zt;
      entry[PAD_PAIR_ZX] = -number(z, x) / zt, entry[PAD_PAIR_ZY] = -number(z, y) / zt;
      entry[PAD_PAIR_YX] = number(y, x) / tt;
      table.insert(table.end(), std::begin(entry), std::end(entry));
    }
  return table;
}

/// The base stress under the tactels by tractions of 1 on held cells, as fem::base_stress_of_cells, times `unit` of n,
/// t_x, t_y.
Eigen::MatrixXd held_stress(const fem::PadLayer& layer, const fem::PadSensor& pad, const fem::PadCells& cells,
                            const std::array<double, 3>& unit) {
  constexpr int column[3] = {2, 0, 1};
  const fem::TactelPoints points(pad);
  const Eigen::Index parts = std::ssize(points.weights), tactels = points.places.rows() / parts;
  const int count = cells.count(), ny = cells.ny(), most = std::max(cells.n, ny);
  Eigen::MatrixXd stress = Eigen::MatrixXd::Zero(3 * tactels, 3 * count);
  for (Eigen::Index k = 0; k < parts * tactels; ++k) {
    const auto at = points.places.row(k);
    const auto all =
        layer.base_stresses(pad.thickness, cells.hx, cells.hy, most, at[0] - cells.x(0), at[1] - cells.y(0));
    for (int i = 0; i < count; ++i)
      for (int part = 0; part < 3; ++part)
        for (int row = 0; row < 3; ++row)
          stress(row * tactels + k / parts, part * count + i) +=
              points.weights[k % parts] * unit[part] * all[i / ny * most + i % ny](row, column[part]);
  }
  return stress;
}

/// Rows [rows][3 cells] times `unit` of n, t_x, t_y, as kernel pad_frames takes them: [blocks of rows][cells][n, t_x,
/// t_y][STEP_FRAME_BLOCK], zeros behind the last row.
std::vector<double> in_blocks(const Eigen::MatrixXd& rows, const std::array<double, 3>& unit) {
  constexpr Eigen::Index block = STEP_FRAME_BLOCK;
  const Eigen::Index cells = rows.cols() / 3;
  std::vector<double> blocks((rows.rows() + block - 1) / block * block * rows.cols());
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    for (Eigen::Index i = 0; i < cells; ++i)
      for (Eigen::Index part = 0; part < 3; ++part)
        blocks[((row / block * cells + i) * 3 + part) * block + row % block] = unit[part] * rows(row, part * cells + i);
  return blocks;
}

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

StepTables::StepTables(const fem::PadSensor& pad, const fem::PadCells& cells, const fem::SoftObject& object,
                       const std::optional<fem::PadSides>& sides, const std::optional<Markers>& markers,
                       const PairInfluence& pairs) {
  const double H = pad.thickness;
  const PadTables tables(fem::rubber(pad), std::max(cells.n, cells.ny()), true);
  influence = tables.shared_influence(cell_size(cells, H), object, cells.n, cells.ny());
  if (!pairs.empty()) {
    influence = table_of_pairs(influence, cells.count(), H, [&](std::size_t place, std::size_t source, int to, int by) {
      return pairs[(place * cells.count() + source) * 9 + 3 * to + by];
    });
  } else if (sides) {
    const fem::PadTable table(fem::pad_layer(pad.poisson).beside(object), *sides, cells, Eigen::Matrix2d::Identity(),
                              {0, 0});
    influence = table_of_pairs(influence, cells.count(), H, [&](int place, int source, int to, int by) {
      return table.row(place / cells.ny(), place % cells.ny(), to, by)[source];
    });
  }
  const StickingDisc disc(tables.layer()->beside(object));
  kt = disc.kt, kr = disc.kr;
  const double of_n = pad.young / influence[PAD_ROOT_ZZ], of_t = pad.young / influence[PAD_ROOT_TT];
  fem::PadScene alone;
  alone.sensor = pad;
  stress = sides ? in_blocks(fem::base_stress_of_cells(*tables.layer(), alone, cells, *sides), {of_n, of_t, of_t})
                 : in_blocks(held_stress(*tables.layer(), pad, cells, {-of_n, of_t, of_t}), {1, 1, 1});  // f_z = -n
  if (markers)
    displacements = in_blocks(fem::marker_rows(*markers, alone, cells, StopScope::checker()), {of_n, of_t, of_t});
}

}  // namespace tactel::host
