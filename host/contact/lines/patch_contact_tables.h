// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <utility>
#include <vector>

#include "fem/layer/layer_model.h"
#include "fem/layer/sensor_family.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {

/// Returns a number of rows that is a multiple of PATCH_BLOCK.
constexpr int padded(int rows) { return (rows + PATCH_BLOCK - 1) / PATCH_BLOCK * PATCH_BLOCK; }

/// Arguments of kernels/patch_contact.cl that stay, by name, for E = 1.
struct KernelTables {
  std::vector<std::pair<const char*, std::vector<double>>> tables{};  ///< empty: none
  std::vector<std::pair<const char*, int>> counts{};
  std::vector<std::pair<const char*, double>> numbers{};
  int tactels = 0;
  int outputs = 0;  ///< sigma_y of all tactels, then tau_xy, then zeros up to a multiple of PATCH_BLOCK
};

/// Returns the tables of a sensor:
/// - smooth [cells][PATCH_BLOCK], cubic coefficients of R_yy, R_xx, R_xy over x / h;
/// - sides [rows][PATCH_BLOCK], v_y, then v_x of each mode, empty without free sides; signs [SIDE_MODES] of the modes;
/// - base [rows][2][outputs], stresses at the tactels, MPa, by n = 1, by t = 1 N/mm at a place;
/// - cy, cx, jump: factors of C_yy and of C_xy; (1 - 2 nu) pi / 2.
KernelTables patch_tables(const fem::LayerModel& model);

/// Returns the tables of a family of sensors, a row for each of `poissons` Poisson's ratios. Distances in thicknesses.
/// - smooth [cells][poissons][PATCH_BLOCK], as above;
/// - sides, side_forces, side_stresses [side rows][PATCH_BLOCK] of EndModes, empty without free sides;
/// - cores [poissons][CORE_NUMBERS]; layer_stresses [stress cells][poissons][STRESS_NUMBERS].
KernelTables family_tables(const fem::SensorFamily& family);

/// The numbers of PatchSensorRow of one sensor.
struct PatchSensor {
  double rows[PATCH_SENSOR_ROWS] = {};
};
PatchSensor patch_sensor(const fem::SensorFamily& family, const fem::Sensor& sensor);

}  // namespace tactel::host
