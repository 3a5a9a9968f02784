// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_model.h"

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "fem/numbers/array_cache.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/processor.h"
#include "fem/numbers/value_error.h"
#include "fem/scenes/rubber.h"

namespace tactel::fem {

void require_sensor_of(const LayerModel& model, const Sensor& sensor) {
  const Sensor& known = model.sensor;
  if (sensor.length != known.length || sensor.thickness != known.thickness || rubber(sensor) != rubber(known) ||
      sensor.tactels != known.tactels || sensor.span() != known.span() || sensor.tactel_width != known.tactel_width)
    throw std::invalid_argument("LayerModel: the scene has another sensor; make a model of its own");
}

namespace {

constexpr double longest_shear = 2;  ///< h: over 22 times as much a table goes, over 12 h changes of a side

void check(const Sensor& sensor) {
  validate(sensor);
  if (!(sensor.length <= longest_sensor * sensor.thickness))
    throw ValueError("sensor.length", number_text(sensor.length),
                     "at most " + number_text(longest_sensor) +
                         " times sensor.thickness where contact is solved on patches; use a mesh instead");
  if (shear_length(sensor.layers) > longest_shear && !(sensor.length <= longest_side_block * sensor.thickness))
    throw ValueError("sensor.length", number_text(sensor.length),
                     "at most " + number_text(longest_side_block) +
                         " times sensor.thickness where layers so stiff carry shear to both ends; or use a mesh");
}

}  // namespace

LayerModel endless_layer(const Sensor& sensor) {
  check(sensor);
  const LayerTable table(rubber(sensor));
  return {FreeSides(), table, BaseStressTable(sensor, table), sensor};
}

namespace {

/// All that the tables depend on, to the last digit; as the key of condensation_cache.cpp. TACTEL_LAYER_FINGERPRINT
/// holds that of the condensation, too.
std::string key_text(const Sensor& s) {
  return "tactel layer\nbuild " TACTEL_LAYER_FINGERPRINT "\nprocessor " + processor_text() + "\nlength " +
         number_text(s.length) + "\nthickness " + number_text(s.thickness) + "\npoisson " + number_text(s.poisson) +
         "\ntactels " + std::to_string(s.tactels) + "\nspan " + number_text(s.span()) + "\nwidth " +
         number_text(s.tactel_width) + "\n" + layers_text(s);
}

/// The numbers of a model, as they stand in a file.
struct ModelNumbers {
  LayerTable::Coefficients table;
  FreeSides::Rows sides;
  FreeSides::Modes sign;
  BaseStressTable::Rows base;

  std::array<std::span<double>, 4> arrays() {
    const auto all = [](auto& matrix) { return std::span(matrix.data(), static_cast<std::size_t>(matrix.size())); };
    return {all(table), all(sides), all(sign), all(base)};
  }
};

std::optional<LayerModel> read_model(const Sensor& sensor, const CacheFile& file) {
  const Rubber stack = rubber(sensor);
  const double top = stack.layers.empty() ? 0 : stack.layers.back().thickness;
  ModelNumbers numbers{
      LayerTable::Coefficients(LayerTable::cells_over(LayerTable::default_range, top), 4 * LayerTable::functions),
      FreeSides::Rows(FreeSides::places(side_block(sensor), sensor.length), 2 * FreeSides::rank),
      FreeSides::Modes(FreeSides::rank),
      BaseStressTable::Rows(BaseStressTable::places(sensor), BaseStressTable::quantities * sensor.tactels)};
  if (!read_arrays(file, numbers.arrays())) return std::nullopt;
  return LayerModel{FreeSides(sensor.length, std::move(numbers.sides), std::move(numbers.sign)),
                    LayerTable(sensor.poisson, std::move(numbers.table), top),
                    BaseStressTable(sensor, std::move(numbers.base)), sensor};
}

void write_model(const LayerModel& model, const CacheFile& file) {
  const auto all = [](const auto& matrix) {
    return std::span<const double>(matrix.data(), static_cast<std::size_t>(matrix.size()));
  };
  const std::span<const double> arrays[] = {all(model.table.coefficients()), all(model.sides.rows()),
                                            all(model.sides.sign()), all(model.base.rows())};
  write_arrays(file, arrays);
}

LayerModel new_layer_model(const Sensor& sensor, const std::filesystem::path& cache_directory) {
  check(sensor);
  const CacheFile file = cache_file(cache_directory, "layer", "tables", key_text(sensor));
  if (auto kept = read_model(sensor, file)) return *std::move(kept);
  LayerModel model = endless_layer(sensor);
  const SideDifference difference = side_difference(side_block(sensor), cache_directory);
  model.sides = FreeSides(difference, sensor.length);
  add_free_sides(difference, sensor, model.base);
  write_model(model, file);
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
  auto made = std::make_shared<const KeptModel>(KeptModel{new_layer_model(sensor, cache_directory), cache_directory});
  const std::lock_guard lock(mutex);
  last = made;
  return made->model;
}

}  // namespace tactel::fem
