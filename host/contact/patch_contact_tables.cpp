#include "host/contact/patch_contact_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactel::host {
namespace {

constexpr int most_cells = 200000;

/// Coefficients of the cubic through f(0), f(1/3), f(2/3), f(1).
void put_cubic(const double (&f)[4], double* c) {
  c[0] = f[0];
  c[1] = -5.5 * f[0] + 9 * f[1] - 4.5 * f[2] + f[3];
  c[2] = 9 * f[0] - 22.5 * f[1] + 18 * f[2] - 4.5 * f[3];
  c[3] = -4.5 * f[0] + 13.5 * f[1] - 13.5 * f[2] + 4.5 * f[3];
}

/// A patch may be as wide as the sensor, and the certificate looks a little beyond its ends.
void put_smooth(const fem::Sensor& sensor, const fem::LayerTable& layer, PatchTables& tables) {
  constexpr int per = fem::LayerTable::cells_a_thickness;
  const int wanted =
      static_cast<int>(std::min(std::ceil(1.5 * sensor.length / sensor.thickness * per), 1.0 * most_cells));
  const int cells = std::max(wanted, 2 * per), known = static_cast<int>(layer.cells());
  tables.cells_per_mm = per / sensor.thickness;
  tables.smooth.assign(static_cast<std::size_t>(cells) * PATCH_BLOCK, 0);
  for (int cell = 0; cell < cells; ++cell) {
    double* row = &tables.smooth[static_cast<std::size_t>(cell) * PATCH_BLOCK];
    if (cell < known) {
      for (int k = 0; k < 3 * LAYER_COEFFICIENTS; ++k) row[k] = layer.coefficients()(cell, k);
      continue;
    }
    double f[3][4];
    for (int point = 0; point < 4; ++point) {
      const fem::SmoothParts R = layer.smooth_integral((cell + point / 3.0) / per);
      f[0][point] = R.yy, f[1][point] = R.xx, f[2][point] = R.xy;
    }
    for (int k = 0; k < 3; ++k) put_cubic(f[k], row + k * LAYER_COEFFICIENTS);
  }
}

void put_sides(const fem::FreeSides& sides, PatchTables& tables) {
  tables.signs.assign(SIDE_MODES, 0);
  if (sides.endless()) return;
  static_assert(fem::FreeSides::rank == SIDE_MODES && 2 * SIDE_MODES == PATCH_BLOCK);
  tables.sides.assign(sides.rows().data(), sides.rows().data() + sides.rows().size());
  tables.signs.assign(sides.sign().begin(), sides.sign().end());
  tables.sides_from = sides.left();
  tables.side_rows_per_mm = 1 / sides.step();
}

/// From a row per quantity and tactel to a row by n and one by t, each padded.
void put_base(const fem::BaseStressTable& table, PatchTables& tables) {
  using Table = fem::BaseStressTable;
  const int count = table.tactels();
  tables.outputs = (2 * count + PATCH_BLOCK - 1) / PATCH_BLOCK * PATCH_BLOCK;
  tables.base_from = table.left();
  tables.base_rows_per_mm = 1 / table.step();
  tables.base.assign(table.rows().rows() * 2 * static_cast<std::size_t>(tables.outputs), 0);
  for (Eigen::Index row = 0; row < table.rows().rows(); ++row) {
    double* by_n = &tables.base[static_cast<std::size_t>(row) * 2 * tables.outputs];
    double* by_t = by_n + tables.outputs;
    for (int k = 0; k < count; ++k) {
      by_n[k] = table.rows()(row, Table::sigma_by_pressure * count + k);
      by_n[count + k] = table.rows()(row, Table::tau_by_pressure * count + k);
      by_t[k] = table.rows()(row, Table::sigma_by_traction * count + k);
      by_t[count + k] = table.rows()(row, Table::tau_by_traction * count + k);
    }
  }
}

}  // namespace

PatchTables patch_tables(const fem::LayerModel& model) {
  PatchTables tables;
  const double poisson = model.sensor.poisson;
  tables.cy = fem::layer_cy(poisson);
  tables.cx = fem::layer_cx(poisson);
  tables.jump = (1 - 2 * poisson) * std::numbers::pi / 2;
  put_smooth(model.sensor, model.table, tables);
  put_sides(model.sides, tables);
  put_base(model.base, tables);
  return tables;
}

}  // namespace tactel::host
