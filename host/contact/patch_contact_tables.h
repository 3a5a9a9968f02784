// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "fem/layer/layer_model.h"
#include "fem/layer/sensor_family.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {

/// Tables of a sensor for kernels/patch_contact.cl, for E = 1.
struct PatchTables {
  std::vector<double> smooth;  ///< [cells][PATCH_BLOCK] cubic coefficients of R_yy, R_xx, R_xy over x / h
  double cells_per_mm = 0;
  double cy = 0, cx = 0, jump = 0;  ///< factors of C_yy and of C_xy; (1 - 2 nu) pi / 2
  std::vector<double> sides;        ///< [rows][PATCH_BLOCK] v_y, then v_x of each mode; empty: no free sides
  std::vector<double> signs;        ///< [SIDE_MODES] of the modes
  double side_rows_per_mm = 0, sides_from = 0;
  std::vector<double> base;  ///< [rows][2][outputs] stresses at the tactels, MPa, by n = 1, by t = 1 N/mm at a place
  double base_rows_per_mm = 0, base_from = 0;
  int outputs = 0;  ///< sigma_y of all tactels, then tau_xy, then zeros up to a multiple of PATCH_BLOCK

  int cells() const { return static_cast<int>(smooth.size() / PATCH_BLOCK); }
  int side_rows() const { return static_cast<int>(sides.size() / PATCH_BLOCK); }
  int base_rows() const { return static_cast<int>(base.size() / (2 * static_cast<std::size_t>(outputs))); }
};

PatchTables patch_tables(const fem::LayerModel& model);

/// Tables of a family of sensors for the kernel, for E = 1; a row for each of `poissons` Poisson's ratios. Distances in
/// thicknesses.
struct FamilyTables {
  int poissons = 0;
  std::vector<double> smooth;                             ///< [cells][poissons][PATCH_BLOCK] as PatchTables::smooth
  std::vector<double> sides, side_forces, side_stresses;  ///< [side rows][PATCH_BLOCK] of EndModes; empty: no sides
  std::vector<double> cores;                              ///< [poissons][CORE_NUMBERS]
  std::vector<double> stresses;                           ///< [stress cells][poissons][STRESS_NUMBERS]

  int cells() const { return static_cast<int>(smooth.size() / PATCH_BLOCK) / poissons; }
  int side_rows() const { return static_cast<int>(sides.size() / PATCH_BLOCK); }
  int stress_cells() const { return static_cast<int>(stresses.size() / STRESS_NUMBERS) / poissons; }
};

FamilyTables family_tables(const fem::SensorFamily& family);

/// The numbers of PatchSensorRow of one sensor.
struct PatchSensor {
  double rows[PATCH_SENSOR_ROWS] = {};
};
PatchSensor patch_sensor(const fem::SensorFamily& family, const fem::Sensor& sensor);

}  // namespace tactel::host
