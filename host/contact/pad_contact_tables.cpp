// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_contact_tables.h"

#include <algorithm>
#include <cmath>

#include "fem/layer/legendre_points.h"
#include "fem/pad/pad_solver.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

/// Tables that are kept: scenes of a sensor meet some 160 of the ladder. One has 30 kB at 24 cells.
constexpr std::size_t most_kept = 512;

/// Whether other scenes are likely to have this size, too.
bool on_ladder(const PadCellSize& size) {
  for (const long long side : {size.hx, size.hy}) {
    const double rung = fem::rungs_an_octave * std::log2(PadCellSize::unit * static_cast<double>(side));
    if (std::abs(rung - std::round(rung)) > 1e-9) return false;
  }
  return true;
}

std::vector<double> stress_table(const fem::PadLayer& layer) {
  std::vector<double> table(PadTables::stress_rows * std::size_t{PAD_BLOCK});
  const double step = 1.0 / PadTables::stress_rows_a_thickness;
  for (int row = 0; row + 1 < PadTables::stress_rows; ++row) {  // the last row is 0: beyond
    const Eigen::Array<double, 5, 1> left = layer.stresses(row * step), middle = layer.stresses((row + 0.5) * step),
                                     right = layer.stresses((row + 1) * step);
    for (int f = 0; f < 5; ++f) {
      double* c =
          &table[static_cast<std::size_t>(row) * PAD_BLOCK + static_cast<std::size_t>(f) * PAD_STRESS_COEFFICIENTS];
      c[0] = left[f], c[2] = 2 * (left[f] - 2 * middle[f] + right[f]), c[1] = right[f] - left[f] - c[2];
    }
  }
  return table;
}

}  // namespace

PadCellSize cell_size(const fem::PadCells& cells, double thickness) {
  const double unit = PadCellSize::unit * thickness;
  return {std::llround(cells.hx / unit), std::llround(cells.hy / unit)};
}

PadTables::PadTables(double poisson, int cells)
    : cells_(cells), layer_(std::make_shared<const fem::PadLayer>(poisson)), stress_(stress_table(*layer_)) {}

std::vector<double> PadTables::make_influence(const PadCellSize& size) const {
  const double hx = PadCellSize::unit * static_cast<double>(size.hx),
               hy = PadCellSize::unit * static_cast<double>(size.hy);
  const fem::CellInfluence own = layer_->influence(1, hx, hy, 0, 0);
  const double zz = std::sqrt(own.zz), tt = std::sqrt(std::max(own.xx, own.yy));
  std::vector<double> table(PAD_TABLE_HEAD + static_cast<std::size_t>((cells_ + 1) * (cells_ + 1)) * PAD_OWN_INFLUENCE);
  table[PAD_ROOT_ZZ] = zz, table[PAD_ROOT_TT] = tt, table[PAD_HX] = hx, table[PAD_HY] = hy;
  double* row = &table[PAD_TABLE_HEAD];
  for (int i = 0; i <= cells_; ++i)
    for (int j = 0; j <= cells_; ++j, row += PAD_OWN_INFLUENCE) {
      const fem::CellInfluence c = layer_->influence(1, hx, hy, i * hx, j * hy);
      row[PAD_ZZ] = c.zz / (zz * zz);
      row[PAD_XX] = c.xx / (tt * tt), row[PAD_YY] = c.yy / (tt * tt), row[PAD_XY] = c.xy / (tt * tt);
      row[PAD_XZ] = c.xz / (zz * tt), row[PAD_YZ] = c.yz / (zz * tt);
    }
  return table;
}

std::shared_ptr<const std::vector<double>> PadTables::influence(const PadCellSize& size) const {
  const bool keep = on_ladder(size);
  if (keep) {
    const std::lock_guard lock(making_);
    if (const auto kept = influence_.find(size); kept != influence_.end()) return kept->second;
  }
  auto made = std::make_shared<const std::vector<double>>(make_influence(size));
  const std::lock_guard lock(making_);
  if (keep && influence_.size() < most_kept) influence_.emplace(size, made);
  return made;
}

std::vector<double> PadTables::shared_influence(const PadCellSize& size) const {
  const int n = cells_, span = 2 * n + 1;
  const std::shared_ptr<const std::vector<double>> own = influence(size);
  std::vector<double> table(PAD_TABLE_HEAD + std::size_t{PAD_INFLUENCE} * span * span);
  std::copy_n(own->begin(), PAD_TABLE_HEAD, table.begin());
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (const int sx : {-1, 1})
        for (const int sy : {-1, 1}) {  // the place lies at +(sx i, sy j) from the source
          double* row = &table[PAD_TABLE_HEAD + std::size_t{PAD_INFLUENCE} * ((n - sx * i) * span + n - sy * j)];
          std::copy_n(&(*own)[PAD_TABLE_HEAD + std::size_t{PAD_OWN_INFLUENCE} * (i * (n + 1) + j)], PAD_OWN_INFLUENCE,
                      row);
          row[PAD_XY] *= sx * sy, row[PAD_XZ] *= sx, row[PAD_YZ] *= sy;
        }
  return table;
}

int TactelPoints::along(const fem::PadSensor& sensor) {
  const double half = sensor.tactel_size / 2;
  return half > 0 ? 3 + static_cast<int>(std::ceil(4 * half / sensor.thickness)) : 1;
}

TactelPoints::TactelPoints(const fem::PadSensor& sensor) {
  const Eigen::MatrixX2d middles = fem::tactel_places(sensor);
  const double half = sensor.tactel_size / 2;
  const std::vector<fem::LegendrePoint> points =
      half > 0 ? fem::legendre_points(along(sensor)) : std::vector<fem::LegendrePoint>{{0, 2}};
  for (const auto& p : points)
    for (const auto& q : points) weights.push_back(p.weight * q.weight / 4);
  places.resize(middles.rows() * static_cast<Eigen::Index>(weights.size()), 2);
  Eigen::Index k = 0;
  for (Eigen::Index tactel = 0; tactel < middles.rows(); ++tactel)
    for (const auto& p : points)
      for (const auto& q : points) places.row(k++) = middles.row(tactel) + half * Eigen::RowVector2d(p.x, q.x);
}

}  // namespace tactel::host
