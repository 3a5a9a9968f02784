#include "host/contact/patch_contact_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/block.h"
#include "fem/layer/layer_table.h"

namespace tactel::host {
namespace {

constexpr int most_cells = 200000;
constexpr double rows_a_thickness = 30, fewest_base_rows = 400;  ///< of the base's table

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
  const int wanted = static_cast<int>(std::min(std::ceil(1.5 * sensor.length / sensor.thickness * per), 1.0 * most_cells));
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

/// Mean base stress over a tactel, which lies `distance` mm to the right of the load; at a point where it has no width.
fem::BaseStress tactel_stress(const fem::LayerTable& layer, double h, double width, double distance) {
  if (width == 0) {
    const fem::BaseStress s = layer.base(distance / h);
    return {s.sigma_by_y / h, s.tau_by_x / h, s.tau_by_y / h, s.sigma_by_x / h};
  }
  const fem::BaseStress a = layer.base_integral((distance - 0.5 * width) / h),
                        b = layer.base_integral((distance + 0.5 * width) / h);
  return {(b.sigma_by_y - a.sigma_by_y) / width, (b.tau_by_x - a.tau_by_x) / width,
          (b.tau_by_y - a.tau_by_y) / width, (b.sigma_by_x - a.sigma_by_x) / width};
}

void put_base(const fem::Sensor& sensor, const fem::LayerTable& layer, PatchTables& tables) {
  const Eigen::VectorXd tactel = fem::tactel_positions(sensor);
  const int count = static_cast<int>(tactel.size());
  tables.outputs = (2 * count + PATCH_BLOCK - 1) / PATCH_BLOCK * PATCH_BLOCK;
  const double rows = std::max(fewest_base_rows, std::ceil(rows_a_thickness * sensor.length / sensor.thickness));
  tables.base_from = -0.5 * sensor.length;
  tables.base_rows_per_mm = rows / sensor.length;
  const int last = static_cast<int>(rows);
  tables.base.assign((last + 1) * 2 * static_cast<std::size_t>(tables.outputs), 0);
  for (int row = 0; row <= last; ++row) {
    double* by_n = &tables.base[static_cast<std::size_t>(row) * 2 * tables.outputs];
    double* by_t = by_n + tables.outputs;
    const double at = tables.base_from + row / tables.base_rows_per_mm;
    for (int k = 0; k < count; ++k) {
      const fem::BaseStress s = tactel_stress(layer, sensor.thickness, sensor.tactel_width, tactel[k] - at);
      by_n[k] = -s.sigma_by_y;
      by_n[count + k] = -s.tau_by_y;
      by_t[k] = s.sigma_by_x;
      by_t[count + k] = s.tau_by_x;
    }
  }
}

}  // namespace

PatchTables patch_tables(const fem::Sensor& sensor) {
  PatchTables tables;
  const fem::LayerTable layer(sensor.poisson);
  tables.cy = fem::layer_cy(sensor.poisson);
  tables.cx = fem::layer_cx(sensor.poisson);
  tables.jump = (1 - 2 * sensor.poisson) * std::numbers::pi / 2;
  put_smooth(sensor, layer, tables);
  tables.signs.assign(SIDE_MODES, 1);
  put_base(sensor, layer, tables);
  return tables;
}

}  // namespace tactel::host
