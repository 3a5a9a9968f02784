// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_model.h"

#include <memory>
#include <mutex>
#include <stdexcept>

#include "fem/number_text.h"
#include "fem/value_error.h"

namespace tactel::fem {

void require_sensor_of(const LayerModel& model, const Sensor& sensor) {
  const Sensor& own = model.sensor;
  if (sensor.length != own.length || sensor.thickness != own.thickness || sensor.poisson != own.poisson ||
      sensor.tactels != own.tactels || sensor.span() != own.span() || sensor.tactel_width != own.tactel_width)
    throw std::invalid_argument("LayerModel: the scene has another sensor; make a model of its own");
}

LayerModel endless_layer(const Sensor& sensor) {
  sensor.validate();
  if (!(sensor.length <= longest_sensor * sensor.thickness))
    throw ValueError("sensor.length", number_text(sensor.length),
                     "at most " + number_text(longest_sensor) +
                         " times sensor.thickness where contact is solved on patches; use a mesh instead");
  const LayerTable table(sensor.poisson);
  return {sensor, table, FreeSides(), BaseStressTable(sensor, table)};
}

namespace {

LayerModel new_layer_model(const Sensor& sensor, const std::filesystem::path& cache_directory) {
  LayerModel model = endless_layer(sensor);
  const SideDifference difference = side_difference(side_block(sensor), cache_directory);
  model.sides = FreeSides(difference, sensor.length);
  add_free_sides(difference, sensor, model.base);
  return model;
}

struct KeptModel {
  LayerModel model;
  std::filesystem::path cache_directory;
};

}  // namespace

LayerModel layer_model(const Sensor& sensor, const std::filesystem::path& cache_directory) {
  static std::mutex mutex;
  static std::shared_ptr<const KeptModel> last;
  {
    const std::lock_guard lock(mutex);
    if (last && last->model.sensor == sensor && last->cache_directory == cache_directory) return last->model;
  }
  auto made = std::make_shared<const KeptModel>(new_layer_model(sensor, cache_directory), cache_directory);
  const std::lock_guard lock(mutex);
  last = made;
  return made->model;
}

}  // namespace tactel::fem
