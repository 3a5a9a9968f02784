// SPDX-License-Identifier: Apache-2.0
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

/// Cells for a sensor of this length, in thicknesses: a patch may be as wide as it, and the certificate looks a little
/// beyond its ends.
int smooth_cells(double length) {
  constexpr int per = fem::LayerTable::cells_a_thickness;
  const int wanted = static_cast<int>(std::min(std::ceil(1.5 * length * per), 1.0 * most_cells));
  return std::max(wanted, 2 * per);
}

void put_smooth_cell(const fem::LayerTable& layer, int cell, double* row) {
  constexpr int per = fem::LayerTable::cells_a_thickness;
  if (cell < layer.cells()) {
    for (int k = 0; k < 3 * LAYER_COEFFICIENTS; ++k) row[k] = layer.coefficients()(cell, k);
    return;
  }
  double f[3][4];
  for (int point = 0; point < 4; ++point) {
    const fem::SmoothParts R = layer.smooth_integral((cell + point / 3.0) / per);
    f[0][point] = R.yy, f[1][point] = R.xx, f[2][point] = R.xy;
  }
  for (int k = 0; k < 3; ++k) put_cubic(f[k], row + k * LAYER_COEFFICIENTS);
}

void put_smooth(const fem::Sensor& sensor, const fem::LayerTable& layer, PatchTables& tables) {
  const int cells = smooth_cells(sensor.length / sensor.thickness);
  tables.cells_per_mm = fem::LayerTable::cells_a_thickness / sensor.thickness;
  tables.smooth.assign(static_cast<std::size_t>(cells) * PATCH_BLOCK, 0);
  for (int cell = 0; cell < cells; ++cell)
    put_smooth_cell(layer, cell, &tables.smooth[static_cast<std::size_t>(cell) * PATCH_BLOCK]);
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

namespace {

std::vector<double> numbers_of(const fem::EndModes::Rows& rows) { return {rows.data(), rows.data() + rows.size()}; }

void put_family_smooth(const fem::SensorFamily& family, FamilyTables& tables) {
  const int cells = smooth_cells(family.range().longest);
  tables.smooth.assign(static_cast<std::size_t>(cells) * tables.poissons * PATCH_BLOCK, 0);
  double* row = tables.smooth.data();
  for (int cell = 0; cell < cells; ++cell)
    for (int k = 0; k < tables.poissons; ++k, row += PATCH_BLOCK) put_smooth_cell(family.table(k), cell, row);
}

void put_family_sides(const fem::SensorFamily& family, FamilyTables& tables) {
  if (!family.sides()) return;
  static_assert(fem::EndModes::rank == SIDE_MODES);
  constexpr int block = PATCH_BLOCK, pairs = CORE_COMPLIANCE, core = CORE_NUMBERS;
  static_assert(pairs + SIDE_MODES * SIDE_MODES <= core && core % block == 0);
  tables.sides = numbers_of(family.ends().displacement);
  tables.side_forces = numbers_of(family.ends().force);
  tables.side_stresses = numbers_of(family.ends().stress);
  for (int k = 0; k < tables.poissons; ++k) {
    const std::size_t end = tables.cores.size() + CORE_NUMBERS;
    for (int r = 0; r < SIDE_MODES; ++r)
      for (int q = r; q < SIDE_MODES; ++q) tables.cores.push_back(family.compliance(k)(r, q));
    for (int r = 0; r < SIDE_MODES; ++r)
      for (int q = 0; q < SIDE_MODES; ++q) tables.cores.push_back(family.base_stress(k)(r, q));
    tables.cores.resize(end, 0);
  }
}

void put_family_stresses(const fem::SensorFamily& family, FamilyTables& tables) {
  constexpr int per = fem::SensorFamily::stress_cells_a_thickness;
  const int cells = static_cast<int>(fem::SensorFamily::stress_reach * per);
  for (int cell = 0; cell < cells; ++cell)
    for (int k = 0; k < tables.poissons; ++k) {
      const auto at = [&](int c) { return family.table(k).base(static_cast<double>(c) / per); };
      const fem::BaseStress here = at(cell), next = at(cell + 1);
      tables.stresses.insert(tables.stresses.end(), {here.sigma_by_y, next.sigma_by_y, here.tau_by_x, next.tau_by_x,
                                                     here.tau_by_y, next.tau_by_y, here.sigma_by_x, next.sigma_by_x});
    }
}

}  // namespace

FamilyTables family_tables(const fem::SensorFamily& family) {
  FamilyTables tables;
  tables.poissons = family.poisson_rows();
  put_family_smooth(family, tables);
  put_family_sides(family, tables);
  put_family_stresses(family, tables);
  return tables;
}

PatchSensor patch_sensor(const fem::SensorFamily& family, const fem::Sensor& sensor) {
  PatchSensor lane;
  const double nu = sensor.poisson;
  lane.rows[SENSOR_THICKNESS] = sensor.thickness;
  lane.rows[SENSOR_LENGTH] = sensor.length;
  lane.rows[SENSOR_POISSON] = family.place(nu);
  lane.rows[SENSOR_CY] = fem::layer_cy(nu);
  lane.rows[SENSOR_CX] = fem::layer_cx(nu);
  lane.rows[SENSOR_JUMP] = (1 - 2 * nu) * std::numbers::pi / 2;
  lane.rows[SENSOR_TACTEL] = sensor.tactels > 1 ? -sensor.span() / 2 : 0;
  lane.rows[SENSOR_SPACING] = sensor.tactels > 1 ? sensor.span() / (sensor.tactels - 1) : 0;
  return lane;
}

}  // namespace tactel::host
