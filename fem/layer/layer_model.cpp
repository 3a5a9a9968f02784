#include "fem/layer/layer_model.h"

namespace tactel::fem {

LayerModel endless_layer(const Sensor& sensor) {
  sensor.validate();
  const LayerTable table(sensor.poisson);
  return {sensor, table, FreeSides(), BaseStressTable(sensor, table)};
}

}  // namespace tactel::fem
