// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "fem/layer/base_stress_table.h"
#include "fem/layer/free_sides.h"
#include "fem/layer/layer_table.h"
#include "fem/mesh/condensation.h"
#include "fem/numbers/cache_directory.h"
#include "fem/scenes/sensor.h"

namespace tactel::fem {

/// All that contact on patches wants to know of a sensor, free of E: tables of the endless layer, of the free sides
/// and of the base stress. Mesh and stress recovery of the sensor do not matter.
struct LayerModel {
  FreeSides sides;
  LayerTable table;
  BaseStressTable base;
  Sensor sensor;
};

/// Throws std::invalid_argument unless this sensor has the model's length, thickness, poisson and tactels.
void require_sensor_of(const LayerModel& model, const Sensor& sensor);

/// Longest sensor that has tables, in thicknesses.
inline constexpr double longest_sensor = 200;

/// Returns the tables of a sensor with its free sides: one condensation of a block. Block and tables are kept in files
/// of the cache (array_cache.h), with the same bits. Throws ValueError for an invalid sensor, or one longer than
/// `longest_sensor`. The last model is kept: asking for it again costs a copy. Threads may call it at the same time.
LayerModel layer_model(const Sensor& sensor, const std::filesystem::path& cache_directory = default_cache_directory());

/// The sensor without free sides: part of an endless layer.
LayerModel endless_layer(const Sensor& sensor);

}  // namespace tactel::fem
