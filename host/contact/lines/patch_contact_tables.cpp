// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/patch_contact_tables.h"

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

/// Of equal width, over h. Layers have as many over their uppermost as one has over h, or as a table may have.
double cells_over_h(const fem::LayerTable& layer, double length) {
  constexpr double per = fem::LayerTable::cells_a_thickness;
  return layer.top() > 0 ? std::min(per / layer.top(), most_cells / (1.5 * length)) : per;
}

/// Cells for a sensor of this length, in thicknesses: a patch may be as wide as it, and the certificate looks a little
/// beyond its ends.
int smooth_cells(double length, double per) {
  const int wanted = static_cast<int>(std::min(std::ceil(1.5 * length * per), 1.0 * most_cells));
  return std::max(wanted, static_cast<int>(2 * per));
}

void put_smooth_cell(const fem::LayerTable& layer, int cell, double per, double* row) {
  if (cell < layer.cells() && layer.top() == 0) {
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

std::vector<double> smooth_rows(const fem::LayerModel& model, double per) {
  const int cells = smooth_cells(model.sensor.length / model.sensor.thickness, per);
  std::vector<double> rows(static_cast<std::size_t>(cells) * PATCH_BLOCK, 0);
  for (int cell = 0; cell < cells; ++cell)
    put_smooth_cell(model.table, cell, per, &rows[static_cast<std::size_t>(cell) * PATCH_BLOCK]);
  return rows;
}

/// From a row per quantity and tactel to a row by n and one by t, each padded.
std::vector<double> base_rows(const fem::BaseStressTable& table, int outputs) {
  using Table = fem::BaseStressTable;
  const int count = table.tactels();
  std::vector<double> rows(table.rows().rows() * 2 * static_cast<std::size_t>(outputs), 0);
  for (Eigen::Index row = 0; row < table.rows().rows(); ++row) {
    double* by_n = &rows[static_cast<std::size_t>(row) * 2 * outputs];
    double* by_t = by_n + outputs;
    for (int k = 0; k < count; ++k) {
      by_n[k] = table.rows()(row, Table::sigma_by_pressure * count + k);
      by_n[count + k] = table.rows()(row, Table::tau_by_pressure * count + k);
      by_t[k] = table.rows()(row, Table::sigma_by_traction * count + k);
      by_t[count + k] = table.rows()(row, Table::tau_by_traction * count + k);
    }
  }
  return rows;
}

template <class Rows>
std::vector<double> numbers_of(const Rows& rows) {
  return {rows.data(), rows.data() + rows.size()};
}

int count_of(const std::vector<double>& table, int numbers) { return static_cast<int>(table.size()) / numbers; }

std::vector<double> family_smooth(const fem::SensorFamily& family) {
  constexpr int per = fem::LayerTable::cells_a_thickness;
  const int cells = smooth_cells(family.range().longest, per), poissons = family.poisson_rows();
  std::vector<double> rows(static_cast<std::size_t>(cells) * poissons * PATCH_BLOCK, 0);
  double* row = rows.data();
  for (int cell = 0; cell < cells; ++cell)
    for (int k = 0; k < poissons; ++k, row += PATCH_BLOCK) put_smooth_cell(family.table(k), cell, per, row);
  return rows;
}

std::vector<double> family_cores(const fem::SensorFamily& family) {
  static_assert(fem::EndModes::rank == SIDE_MODES);
  constexpr int block = PATCH_BLOCK, pairs = CORE_COMPLIANCE, core = CORE_NUMBERS;
  static_assert(pairs + SIDE_MODES * SIDE_MODES <= core && core % block == 0);
  std::vector<double> cores;
  for (int k = 0; k < family.poisson_rows(); ++k) {
    const std::size_t end = cores.size() + CORE_NUMBERS;
    for (int r = 0; r < SIDE_MODES; ++r)
      for (int q = r; q < SIDE_MODES; ++q) cores.push_back(family.compliance(k)(r, q));
    for (int r = 0; r < SIDE_MODES; ++r)
      for (int q = 0; q < SIDE_MODES; ++q) cores.push_back(family.base_stress(k)(r, q));
    cores.resize(end, 0);
  }
  return cores;
}

std::vector<double> family_stresses(const fem::SensorFamily& family) {
  constexpr int per = fem::SensorFamily::stress_cells_a_thickness;
  const int cells = static_cast<int>(fem::SensorFamily::stress_reach * per);
  std::vector<double> stresses;
  for (int cell = 0; cell < cells; ++cell)
    for (int k = 0; k < family.poisson_rows(); ++k) {
      const auto at = [&](int c) { return family.table(k).base(static_cast<double>(c) / per); };
      const fem::BaseStress here = at(cell), next = at(cell + 1);
      stresses.insert(stresses.end(), {here.sigma_by_y, next.sigma_by_y, here.tau_by_x, next.tau_by_x, here.tau_by_y,
                                       next.tau_by_y, here.sigma_by_x, next.sigma_by_x});
    }
  return stresses;
}

}  // namespace

KernelTables patch_tables(const fem::LayerModel& model) {
  const fem::Sensor& sensor = model.sensor;
  const fem::FreeSides& free_sides = model.sides;
  static_assert(fem::FreeSides::rank == SIDE_MODES && 2 * SIDE_MODES == PATCH_BLOCK);
  const bool endless = free_sides.endless();
  const int tactels = model.base.tactels(), outputs = padded(2 * tactels);
  const double per = cells_over_h(model.table, sensor.length / sensor.thickness);
  const std::vector<double> smooth = smooth_rows(model, per), base = base_rows(model.base, outputs);
  const std::vector<double> sides = endless ? std::vector<double>() : numbers_of(free_sides.rows());
  std::vector<double> signs(SIDE_MODES, 0);
  if (!endless) signs.assign(free_sides.sign().begin(), free_sides.sign().end());
  return {{{"smooth", smooth}, {"sides", sides}, {"signs", signs}, {"base", base}},
          {{"cells", count_of(smooth, PATCH_BLOCK)},
           {"side_rows", count_of(sides, PATCH_BLOCK)},
           {"base_rows", count_of(base, 2 * outputs)}},
          {{"cells_per_mm", per / sensor.thickness},
           {"thickness", sensor.thickness},
           {"length", sensor.length},
           {"cy", fem::layer_cy(sensor.poisson)},
           {"cx", fem::layer_cx(sensor.poisson)},
           {"jump", (1 - 2 * sensor.poisson) * std::numbers::pi / 2},
           {"side_rows_per_mm", endless ? 0 : 1 / free_sides.step()},
           {"sides_from", endless ? 0 : free_sides.left()},
           {"base_rows_per_mm", 1 / model.base.step()},
           {"base_from", model.base.left()}},
          tactels,
          outputs};
}

KernelTables family_tables(const fem::SensorFamily& family) {
  const bool with_sides = family.sides();
  const int poissons = family.poisson_rows(), tactels = family.range().tactels;
  const auto side = [&](fem::EndModes::Rows fem::EndModes::*rows) {
    return with_sides ? numbers_of(family.ends().*rows) : std::vector<double>();
  };
  const std::vector<double> smooth = family_smooth(family), stresses = family_stresses(family);
  const std::vector<double> sides = side(&fem::EndModes::displacement);
  return {{{"smooth", smooth},
           {"sides", sides},
           {"side_forces", side(&fem::EndModes::force)},
           {"side_stresses", side(&fem::EndModes::stress)},
           {"cores", with_sides ? family_cores(family) : std::vector<double>()},
           {"layer_stresses", stresses}},
          {{"cells", count_of(smooth, poissons * PATCH_BLOCK)},
           {"poissons", poissons},
           {"side_rows", count_of(sides, PATCH_BLOCK)},
           {"stress_cells", count_of(stresses, poissons * STRESS_NUMBERS)},
           {"tactels", tactels}},
          {{"cells_per_h", fem::LayerTable::cells_a_thickness},
           {"side_rows_per_h", fem::EndModes::rows_a_thickness},
           {"stress_cells_per_h", fem::SensorFamily::stress_cells_a_thickness}},
          tactels,
          padded(tactels + padded(tactels))};
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
