#pragma once
#include "fem/layer/base_stress_table.h"
#include "fem/layer/free_sides.h"
#include "fem/layer/layer_table.h"
#include "fem/sensor.h"

namespace tactel::fem {

/// All that contact on patches wants to know of a sensor, free of E: tables of the endless layer, of the free sides
/// and of the base stress. Mesh and stress recovery of the sensor do not matter.
struct LayerModel {
  Sensor sensor;
  LayerTable table;
  FreeSides sides;
  BaseStressTable base;
};

/// The sensor without free sides: part of an endless layer.
LayerModel endless_layer(const Sensor& sensor);

}  // namespace tactel::fem
