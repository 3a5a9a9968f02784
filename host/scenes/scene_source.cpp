// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/scene_source.h"

#include <algorithm>
#include <cmath>

#include "fem/mesh/block.h"
#include "fem/numbers/angles.h"
#include "fem/pad/pad_solver.h"
#include "host/scenes/sweep_reader.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

template <class Draw>
double draw_number(const Draw& from, DrawKey key) {
  key.draw = from.number;
  return draw(from.distribution, key);
}

template <class Part>
const auto& draw_alternative(const Part& part, DrawKey key) {
  key.draw = part.number;
  return part.alternatives.size() == 1 ? part.alternatives[0] : part.alternatives[draw_weighted(part.weights, key)];
}

template <class Alternative, class Scene>
void draw_numbers(const Alternative& from, Scene& scene, const DrawKey& key) {
  for (const auto& number : from.draws) number.put(scene, draw_number(number, key));
}

/// Slopes between -1 and 1 in increasing order make it convex; then it is stretched to its width and height.
fem::Profile draw_profile(const SceneSource::RandomProfile& from, DrawKey key) {
  const double half_width = draw_number(from.half_width, key), height = draw_number(from.height, key);
  const int pieces = from.points - 1;
  std::vector<double> slopes;
  slopes.reserve(static_cast<std::size_t>(pieces));
  if (key.quantiles)
    for (int i = 0; i < pieces; ++i) slopes.push_back(2 * key.quantiles[from.slopes + static_cast<std::size_t>(i)] - 1);
  key.draw = from.number;
  for (std::uint32_t attempt = 0; static_cast<int>(slopes.size()) < pieces; ++attempt)
    for (const std::uint32_t word : random_words(key, attempt))
      if (static_cast<int>(slopes.size()) < pieces) slopes.push_back(2 * (word + 0.5) * 0x1p-32 - 1);
  std::ranges::sort(slopes);
  fem::Profile profile;
  profile.x.reserve(static_cast<std::size_t>(from.points)), profile.y.reserve(static_cast<std::size_t>(from.points));
  profile.y = {0};
  for (const double slope : slopes) profile.y.push_back(profile.y.back() + slope);
  const auto [least, most] = std::ranges::minmax(profile.y);
  for (int i = 0; i < from.points; ++i) {
    profile.x.push_back(half_width * (2.0 * i / pieces - 1));
    profile.y[i] = height * (profile.y[i] - least) / (most - least);
  }
  profile.smooth = 1e-9 * height;  // rounding must not count as a dent
  return profile;
}

/// What of a contact is drawn, or taken from its indenter, beside its numbers.
void draw_others(const SceneSource::Alternative& indenter, const SceneSource::Alternative& load, fem::Scene& scene,
                 const DrawKey& key) {
  if (indenter.profile) scene.indenter.shape = draw_profile(*indenter.profile, key);
  if (load.slip_index) scene.load.angle = fem::degrees(std::atan(draw_number(*load.slip_index, key) * scene.friction));
}
void draw_others(const PadSource::Alternative& indenter, const PadSource::Alternative&, fem::PadScene& scene,
                 const DrawKey&) {
  scene.markers = indenter.scene.markers, scene.camera = indenter.scene.camera;
}

void put_friction(fem::Scene& scene, const fem::Scene& contact) { scene.friction = contact.friction; }
void put_friction(fem::PadScene& scene, const fem::PadScene& contact) {
  scene.friction = contact.friction, scene.friction_map = contact.friction_map;
}

// Pads have no models of their surface.
void put_model(fem::Scene& scene, fem::SurfaceModel model) { scene.model = model; }
void put_model(fem::PadScene&, fem::SurfaceModel) {}
fem::PadScene on_rung(const fem::PadScene& scene, const Rung&) { return scene; }

/// Places of the tactels along an axis; empty where sensors differ, `drawn` ones, too.
std::vector<float> tactels_along(const std::vector<fem::Sensor>& sensors, const SceneSource::Part& drawn, int axis) {
  if (axis > 0) return {};
  const auto length = number_place<fem::Scene>("sensor.length", ""),
             span = number_place<fem::Scene>("sensor.tactel_span", "");
  for (const auto& sensor : drawn.alternatives)
    for (const auto& draw : sensor.draws)
      if (draw.place == span || (draw.place == length && !sensor.scene.sensor.tactel_span)) return {};
  for (const fem::Sensor& sensor : sensors)
    if (sensor.span() != sensors[0].span()) return {};
  const Eigen::VectorXf x = fem::tactel_positions(sensors[0]).cast<float>();
  return {x.begin(), x.end()};
}
std::vector<float> tactels_along(const std::vector<fem::PadSensor>& sensors, const PadSource::Part&, int axis) {
  const Eigen::MatrixX2f places = fem::tactel_places(sensors.front()).cast<float>();
  for (const fem::PadSensor& sensor : sensors)
    if (sensor.tactels != sensors.front().tactels || sensor.pitch != sensors.front().pitch) return {};
  return {places.col(axis).begin(), places.col(axis).end()};
}

}  // namespace

template <class Scene>
SourceOf<Scene> SourceOf<Scene>::read(const std::filesystem::path& path, std::optional<std::uint64_t> seed) {
  return SweepReaderOf<Scene>(TomlFile(path), seed).read();
}

template <class Scene>
SourceOf<Scene>::SourceOf(std::vector<Scene> scenes, std::vector<std::uint16_t> kinds,
                          std::vector<std::string> kind_names)
    : listed_(std::move(scenes)), listed_kinds_(std::move(kinds)) {
  contacts_ = listed_.size(), endless_ = listed_.empty();
  kind_names_.swap(kind_names);
  for (const Scene& scene : listed_)
    if (std::ranges::find(sensors_, scene.sensor) == sensors_.end()) sensors_.push_back(scene.sensor);
  inputs_ = inputs_of(sensors_.front());
}

template <class Scene>
ContactParametersOf<Scene> SourceOf<Scene>::parameters() const {
  std::vector<Scene> scenes = listed_;
  for (const Alternative& indenter : indenter_.alternatives) scenes.push_back(indenter.scene);
  return {scenes, sensors_, own_sensors_.has_value()};
}

template <class Scene>
std::vector<float> SourceOf<Scene>::tactel_x() const {
  return tactels_along(sensors_, sensor_, 0);
}

template <class Scene>
std::vector<float> SourceOf<Scene>::tactel_y() const {
  return tactels_along(sensors_, sensor_, 1);
}

template <>
void SourceOf<fem::Scene>::model_on(const Rung& rung) {
  if (own_sensors_ && !rung.patch())
    throw ConfigError(file_, "[sweep] sensors", "(missing)",
                      "a number of sensors to draw where rung " + rung.name +
                          " solves on a mesh: each sensor needs a condensation there");
  rung_ = rung;
  model_ = rung.patch() ? fem::SurfaceModel::patch : fem::SurfaceModel::mesh;
  for (Sensor& sensor : sensors_) {
    fem::Scene scene;
    scene.sensor = sensor;
    sensor = on_rung(scene, rung).sensor;
  }
}

/// Gives each number its quantile: those of slopes and of paths are behind the `draws` others.
template <class Scene>
void SourceOf<Scene>::lay_out_quantiles(std::size_t draws) {
  numbers_.assign(draws, false);
  const auto take = [&](const NumberDraw& draw) { numbers_[draw.number] = continuous(draw.distribution); };
  const auto append = [&](std::size_t count) {
    const auto first = static_cast<std::uint32_t>(numbers_.size());
    numbers_.resize(numbers_.size() + count, true);
    return first;
  };
  for (Part* part : {&indenter_, &contact_, &load_, &sensor_})
    for (Alternative& alternative : part->alternatives) {
      std::ranges::for_each(alternative.draws, take);
      if (auto& profile = alternative.profile) {
        take(profile->half_width), take(profile->height);
        profile->slopes = append(static_cast<std::size_t>(profile->points) - 1);
      }
      if (alternative.slip_index) take(*alternative.slip_index);
      if (alternative.irregular) alternative.path = append(alternative.irregular->most_draws());
      if (alternative.hold) alternative.path = append(alternative.hold->most_draws());
    }
}

template <class Scene>
SourceOf<Scene> SourceOf<Scene>::of_quantiles(std::span<const double> quantiles) const {
  SourceOf source = *this;
  source.contacts_ = quantiles.size() / numbers_.size();
  source.endless_ = false;
  source.quantiles_.assign(quantiles.begin(), quantiles.end());
  return source;
}

template <class Scene>
typename SourceOf<Scene>::Contact SourceOf<Scene>::contact(std::uint64_t k) const {
  Contact contact = drawn_contact(k);
  if (rung_ && !rung_->patch()) contact.scene = on_rung(contact.scene, *rung_);
  return contact;
}

template <class Scene>
DrawKey SourceOf<Scene>::key_of(std::uint64_t k) const {
  DrawKey key{.seed = seed_, .stream = nn::RandomStream::contact, .item = k};
  if (!quantiles_.empty()) key.quantiles = &quantiles_[k * numbers_.size()];
  return key;
}

template <class Scene>
typename SourceOf<Scene>::Contact SourceOf<Scene>::drawn_contact(std::uint64_t k) const {
  if (!listed_.empty()) return {listed_[k], listed_kinds_[k]};
  DrawKey key = key_of(k);
  const Alternative& indenter = draw_alternative(indenter_, key);
  const Alternative &contact = draw_alternative(contact_, key), &load = draw_alternative(load_, key);
  Contact drawn;
  drawn.kind = static_cast<std::uint16_t>(&indenter - indenter_.alternatives.data());
  Scene& scene = drawn.scene;
  put_model(scene, model_);
  if (own_sensors_) {
    const Alternative& sensor = draw_alternative(sensor_, key);
    scene.sensor = sensor.scene.sensor;
    draw_numbers(sensor, scene, key);
  } else {
    scene.sensor = sensors_.size() == 1 ? sensors_[0] : sensors_[draw_weighted(sensor_weights_, key)];
  }
  scene.indenter = indenter.scene.indenter;
  put_friction(scene, contact.scene);
  scene.load = load.scene.load;
  for (const Alternative* part : {&indenter, &contact, &load}) draw_numbers(*part, scene, key);
  draw_others(indenter, load, scene, key);
  if (load.irregular) {
    if (key.quantiles) key.quantiles += load.path;
    draw_irregular_load(*load.irregular, key, scene.load);
  }
  try {
    scene.validate();
  } catch (const ValueError& error) {
    throw ValueError(error.key, error.value,
                     error.allowed + " (drawn for contact " + std::to_string(k) + " of the sweep)");
  }
  return drawn;
}

template <class Scene>
Hold SourceOf<Scene>::hold(std::uint64_t k) const {
  DrawKey key = key_of(k);
  const Alternative &indenter = draw_alternative(indenter_, key), &load = draw_alternative(load_, key);
  if (key.quantiles) key.quantiles += load.path;
  return draw_hold(load.hold.value(), indenter.unevenness, key);
}

template class SourceOf<fem::Scene>;
template class SourceOf<fem::PadScene>;

bool tactels_at_ends(const fem::Sensor& sensor) {
  return sensor.tactels > 1 && sensor.tactel_width == 0 && sensor.span() > sensor.length * (1 - 1e-6);
}

bool tactels_at_ends(const SceneSource& source) {
  return std::ranges::any_of(source.sensors(), [](const fem::Sensor& sensor) { return tactels_at_ends(sensor); });
}

}  // namespace tactel::host
