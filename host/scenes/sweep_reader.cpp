// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/sweep_reader.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "fem/pad/side_kernel.h"
#include "host/scenes/distributed_keys.h"
#include "host/scenes/distribution.h"
#include "host/scenes/pad_file.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/scene_tables.h"
#include "host/scenes/shape_reader.h"
#include "host/support/checksum.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

using std::string;
constexpr std::array part_names{"sensor", "indenter", "contact", "load"};
constexpr int most_sensors = 10000, usual_sensors = 16;
constexpr std::size_t most_poissons = 16;  ///< of pads, which have their own tables
constexpr std::int64_t most_contacts = std::int64_t{1} << 40;
constexpr const char* one_width = "the same for every [[sensor]]: a set's frames are of one width";

template <class Scene>
constexpr bool of_lines = SourceOf<Scene>::of_lines;

/// Keys of a sweep that scene files do not have.
template <class Scene>
bool own_key(const string& table, std::string_view key) {
  if (key == "weight" || (table == "load" && key == "irregular")) return true;
  if (!of_lines<Scene>) return (table == "load" && key == "hold") || (table == "indenter" && key == "unevenness");
  return (table == "load" && key == "slip_index") || (table == "indenter" && key == "points");
}

/// A random profile is read as some profile; its half_width and height belong to the sweep.
template <class Scene>
bool is_random_profile(const string& name, const toml::table& table) {
  return of_lines<Scene> && name == "indenter" && table.contains("points");
}

/// Pads have no models of their surface.
fem::SurfaceModel model_of(const fem::Scene& scene) { return scene.model; }
fem::SurfaceModel model_of(const fem::PadScene&) { return {}; }

/// Layers of a sensor are not drawn.
bool has_plain_tables(const string& name, std::string_view key) { return name == "sensor" && key == "layers"; }

/// Calls f(array, i, index) for the tables of an array, and of those in it: `index` counts through them.
template <class Array, class F>
void each_table(Array& array, const F& f) {
  int index = 0;
  for (std::size_t i = 0; i < array.size(); ++i, ++index) {
    if (array[i].is_table()) f(array, i, index);
    if (auto* inner = array[i].as_array()) {
      index = static_cast<int>(i * inner->size());
      for (std::size_t k = 0; k < inner->size(); ++k, ++index)
        if ((*inner)[k].is_table()) f(*inner, k, index);
      --index;
    }
  }
}

/// Takes the sweep's own keys out and puts `number(key, node)` in place of every distribution.
template <class Scene, class Number>
void make_plain(const string& name, toml::table& table, const Number& number) {
  const bool random = is_random_profile<Scene>(name, table);
  std::vector<string> keys;
  for (const auto& [key, node] : table) keys.emplace_back(key.str());
  for (const string& key : keys) {
    toml::node& node = *table.get(key);
    if (own_key<Scene>(name, key) || (random && (key == "half_width" || key == "height"))) {
      table.erase(key);
    } else if (has_plain_tables(name, key)) {
      continue;
    } else if (node.is_table()) {
      table.insert_or_assign(key, number(key, node));
    } else if (toml::array* array = node.as_array()) {
      each_table(*array,
                 [&](toml::array& list, std::size_t i, int) { list.replace(list.cbegin() + i, number(key, list[i])); });
    }
  }
  if (random) {
    table.insert_or_assign("x", toml::array{-1.0, 0.0, 1.0});
    table.insert_or_assign("y", toml::array{1.0, 0.0, 1.0});
  }
}

fem::Scene read_plain(const TomlFile& file, const fem::Scene*) {
  TomlTable root(file, "");
  fem::Scene scene;
  const bool preset = root.read_choice("preset", {"paper"}).has_value();
  if (preset) scene = paper_preset();
  read_title(root, scene.title);
  for (const char* table : part_names) root.expect_table(table);
  root.finish();
  read_sensor(file, scene, preset ? fem::SurfaceModel::mesh : usual_model);
  read_indenter(file, scene.indenter, preset);
  read_contact(file, scene.friction);
  read_load(file, scene.load, preset);
  return scene;
}

fem::PadScene read_plain(const TomlFile& file, const fem::PadScene*) {
  if (!is_pad(file)) throw file.error("sensor.kind", nullptr, "\"pad\" in every [[sensor]], or in none");
  fem::PadScene scene = read_pad(file);
  // Contacts with free sides take some ten times longer: they are asked for.
  if (!TomlTable(file, "sensor").has("sides")) scene.sensor.sides = fem::Sides::held;
  return scene;
}

/// Name of a measured file of a shape, and the checksum of its numbers.
using FileSum = std::optional<std::pair<string, string>>;
FileSum file_sum(const string& file, std::initializer_list<std::span<const double>> numbers) {
  if (file.empty()) return {};
  RunningChecksum sum;
  for (const auto& part : numbers) sum.add({reinterpret_cast<const char*>(part.data()), part.size_bytes()});
  return std::pair{std::filesystem::path(file).filename().string(), sum.text()};
}
FileSum file_of(const fem::Shape& shape) {
  const auto* profile = std::get_if<fem::Profile>(&shape);
  return profile ? file_sum(profile->file, {profile->x, profile->y}) : FileSum{};
}
FileSum file_of(const fem::PadShape& shape) {
  const auto* map = std::get_if<fem::HeightMap>(&shape);
  if (!map) return {};
  return file_sum(map->file, {{&map->pitch, 1}, {map->heights.data(), static_cast<std::size_t>(map->heights.size())}});
}

}  // namespace

template <class Scene>
SweepReaderOf<Scene>::SweepReaderOf(TomlFile file, std::optional<std::uint64_t> seed)
    : file_(std::move(file)), seed_(seed) {}

/// [name] once, [[name]] several times, or not at all (one null).
template <class Scene>
std::vector<const toml::table*> SweepReaderOf<Scene>::tables(const string& name) const {
  const toml::node* node = file_.root().get(name);
  if (node == nullptr) return {nullptr};
  if (const toml::table* table = node->as_table()) return {table};
  std::vector<const toml::table*> all;
  if (const toml::array* array = node->as_array())
    for (const toml::node& element : *array) all.push_back(element.as_table());
  if (all.empty() || std::ranges::find(all, nullptr) != all.end())
    throw file_.error(name, node, "a table [" + name + "], or several [[" + name + "]]");
  return all;
}

template <class Scene>
auto SweepReaderOf<Scene>::distributions(const string& name, const toml::table& table) const -> std::vector<Found> {
  std::vector<Found> found;
  const auto add = [&](const string& key, int index, const toml::node& node) {
    if (auto distribution = read_distribution(file_, key, node))
      found.push_back({key, index, std::move(*distribution), &node});
  };
  const bool random = is_random_profile<Scene>(name, table);
  for (const auto& [key, node] : table) {
    const string full = name + "." + string(key.str());
    if (own_key<Scene>(name, key.str()) || (random && (key == "half_width" || key == "height"))) continue;
    if (has_plain_tables(name, key.str())) continue;
    add(full, -1, node);
    if (const toml::array* array = node.as_array())
      each_table(*array, [&](const toml::array& list, std::size_t i, int index) { add(full, index, list[i]); });
  }
  return found;
}

template <class Scene>
double SweepReaderOf<Scene>::weight(const string& name, const toml::table& table) const {
  const toml::node* node = table.get("weight");
  if (node == nullptr) return 1;
  const auto value = toml_number(*node);
  if (!value || !(*value >= 0) || !std::isfinite(*value))
    throw file_.error(name + ".weight", node, "a number, at least 0: relative frequency of this table");
  return *value;
}

/// The file as a scene file: alternative `chosen` of table `name`, the first of the others; the smallest number for
/// each distribution.
template <class Scene>
TomlFile SweepReaderOf<Scene>::concrete(const string& name, std::size_t chosen) const {
  TomlFile file(file_.path(), file_.text());
  for (const char* table : {"sweep", "transducer"}) file.root().erase(table);
  for (const string part : part_names) {
    toml::node* node = file.root().get(part);
    if (node == nullptr) continue;
    if (toml::array* array = node->as_array()) {
      toml::table one = std::move(*(*array)[part == name ? chosen : 0].as_table());
      file.root().insert_or_assign(part, std::move(one));
    }
    toml::table& table = *file.root().get(part)->as_table();
    make_plain<Scene>(part, table, [&](const string& key, const toml::node& node) {
      string place = part;
      place.append(".").append(key);
      return ends(read_distribution(file_, place, node).value()).first;
    });
  }
  return file;
}

template <class Scene>
Scene SweepReaderOf<Scene>::read_scene(const TomlFile& file) const {
  Scene scene = read_plain(file, static_cast<const Scene*>(nullptr));
  scene.title.clear();  // of the sweep, not of each contact
  return scene;
}

template <class Scene>
typename SweepReaderOf<Scene>::NumberDraw SweepReaderOf<Scene>::number_draw(const Found& found, const string& shape) {
  const string table = found.key.substr(0, found.key.find('.'));
  const NumberPlace<Scene> place = number_place<Scene>(found.key, shape);
  if (place == nullptr)
    throw file_.error(found.key, found.node,
                      "a plain value; the keys of [" + table + "] that may be distributions are " +
                          listed(drawable_keys<Scene>(table, shape)));
  return {next_++, found.distribution, place, std::max(found.index, 0)};
}

/// A number or a distribution of a key that the sweep itself uses.
template <class Scene>
typename SweepReaderOf<Scene>::NumberDraw SweepReaderOf<Scene>::whole_draw(const string& key, const toml::node* node,
                                                                           const char* allowed) {
  const auto value = node != nullptr ? toml_number(*node) : std::nullopt;
  auto distribution = node != nullptr ? read_distribution(file_, key, *node) : std::nullopt;
  if (!distribution && value) distribution = ChoiceDraw{{*value}, {1}};
  if (!distribution) throw file_.error(key, node, string("given, ") + allowed);
  return {next_++, *distribution, nullptr, 0};
}

template <class Scene>
void SweepReaderOf<Scene>::take_random_profile(const toml::table& table, Alternative& into) {
  constexpr const char* some_mm = "a number of mm above 0, or a distribution";
  const auto points = table["points"].value<std::int64_t>();
  if (!table["points"].is_integer() || *points < 3 || *points > 1000)
    throw file_.error("indenter.points", table.get("points"),
                      "a whole number of points of a random convex profile, 3 to 1000");
  typename Source::RandomProfile profile{
      .points = static_cast<int>(*points),
      .number = next_++,
      .half_width = whole_draw("indenter.half_width", table.get("half_width"), some_mm),
      .height = whole_draw("indenter.height", table.get("height"), some_mm)};
  for (const auto& [key, draw] : {std::pair{"half_width", &profile.half_width}, {"height", &profile.height}})
    if (!(ends(draw->distribution).first > 1e-6))
      throw file_.error(string("indenter.") + key, table.get(key), "above 1e-6 mm");
  into.profile = profile;
}

/// Every distribution at its largest number, the others at their smallest: the model must accept it.
template <class Scene>
void SweepReaderOf<Scene>::check_ends(const Alternative& alternative, const std::vector<Found>& found) const {
  const auto blame = [&](const ValueError& error) {
    const auto its = std::ranges::find(found, error.key, &Found::key);
    return its == found.end() ? file_.error(error) : file_.error(its->key, its->node, error.allowed);
  };
  try {
    alternative.scene.validate();
    for (const NumberDraw& draw : alternative.draws) {
      Scene scene = alternative.scene;
      draw.put(scene, ends(draw.distribution).second);
      scene.validate();
    }
  } catch (const ValueError& error) {
    throw blame(error);
  }
}

template <class Scene>
const toml::table& SweepReaderOf<Scene>::table_of_path(const toml::table& load, const toml::node& node,
                                                       const string& name) const {
  for (const char* key : {"tangential_step", "tangential_steps", "tangential", "twist", "twist_step", "angle",
                          "slip_index", "indentation_steps", "times"})
    if (const toml::node* other = load.get(key))
      throw file_.error(string("load.") + key, other, "left out, because " + name + " is given too");
  if (const toml::table* table = node.as_table()) return *table;
  throw file_.error(name, &node, "a table: [" + name + "]");
}

template <>
void SweepReaderOf<fem::Scene>::take_own_keys(const string& name, const toml::table& table,
                                              SceneSource::Alternative& into) {
  if (is_random_profile<fem::Scene>(name, table)) take_random_profile(table, into);
  const toml::node* node = table.get("slip_index");
  if (name != "load" || node == nullptr) return;
  into.slip_index = whole_draw("load.slip_index", node, "a number from -1 to 1 (not reached), or a distribution");
  const auto [low, high] = ends(into.slip_index->distribution);
  if (!(low > -1 && high < 1)) throw file_.error("load.slip_index", node, "above -1 and below 1");
  if (into.scene.load.normal_force.empty() || into.scene.load.angle)
    throw file_.error("load.slip_index", node, "given with load.normal_force and without load.angle");
}
template <>
void SweepReaderOf<fem::PadScene>::take_own_keys(const string& name, const toml::table& table,
                                                 PadSource::Alternative& into) {
  if (const toml::node* node = table.get("unevenness"); name == "indenter" && node != nullptr)
    into.unevenness = read_unevenness(file_, *node);
  const toml::node* node = table.get("hold");
  if (name != "load" || node == nullptr) return;
  const toml::table& hold = table_of_path(table, *node, "load.hold");
  if (const toml::node* other = table.get("irregular"))
    throw file_.error("load.irregular", other, "left out, because load.hold is given too");
  if (into.scene.load.normal_force.size() != 1)
    throw file_.error("load.hold", node, "given with one normal_force, in N");
  into.hold = read_hold_load(file_, hold);
}

template <class Scene>
typename SweepReaderOf<Scene>::Alternative SweepReaderOf<Scene>::alternative(const string& name, std::size_t chosen,
                                                                             const toml::table& table) {
  Alternative made;
  const TomlFile file = concrete(name, chosen);
  made.scene = read_scene(file);
  const auto found = distributions(name, table);
  for (const Found& f : found) made.draws.push_back(number_draw(f, fem::shape_name(made.scene.indenter.shape)));
  check_ends(made, found);
  if (const toml::node* node = table.get("irregular"); name == "load" && node != nullptr)
    take_irregular(table, *node, made);
  take_own_keys(name, table, made);
  return made;
}

/// Grips in all loads or in none, on sensors that they share, and uneven faces with them alone.
template <>
void SweepReaderOf<fem::PadScene>::check_holds(const PadSource& source) const {
  const auto of_hold = [](const Alternative& load) { return load.hold.has_value(); };
  const bool any = std::ranges::any_of(source.load_.alternatives, of_hold);
  if (any && !std::ranges::all_of(source.load_.alternatives, of_hold))
    throw file_.error("load.hold", nullptr, "in every [[load]], or in none");
  if (any && source.own_sensors())
    throw file_.error("sweep.sensors", nullptr, "a number of sensors to draw, which grips share");
  const auto creeps = [](const auto& sensor) { return !sensor.relaxation.empty(); };
  const auto timed = [](const Alternative& load) { return !load.scene.load.times.empty(); };
  const auto rate = [](const Alternative& load) { return load.hold ? load.hold->rate : 0; };
  const auto& loads = source.load_.alternatives;
  const double first = rate(loads.front());
  const auto of_first = [&](const Alternative& load) { return rate(load) == first; };
  if (!any && std::ranges::any_of(loads, timed)) {
    if (!std::ranges::all_of(source.sensors_, creeps) || !std::ranges::all_of(loads, timed))
      throw file_.error("load.times", nullptr, "in every [[load]], with relaxation in every [[sensor]], or in none");
  } else if (std::ranges::any_of(source.sensors_, creeps) && !(first > 0 && std::ranges::all_of(loads, of_first))) {
    throw file_.error("sensor.relaxation", nullptr,
                      "left out, or given with load.times, or with one [load.hold] rate, in Hz");
  }
  if (any)
    for (const auto& contact : source.contact_.alternatives)
      if (contact.scene.friction_map)
        throw file_.error("contact.friction_map", nullptr, "left out with [load.hold], which has one mu");
  const auto all = tables("indenter");
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!any && source.indenter_.alternatives[i].unevenness)
      throw file_.error("indenter.unevenness", all[i]->get("unevenness"), "left out, or given with [load.hold]");
    if (any && source.indenter_.alternatives[i].scene.indenter.young)
      throw file_.error("indenter.young", all[i]->get("young"), "left out with [load.hold], whose objects are rigid");
  }
}

/// Files that maps of friction name.
template <>
void SweepReaderOf<fem::PadScene>::take_maps(PadSource& source) const {
  const auto all = tables("contact");
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto name = all[i] ? (*all[i])["friction_map"].value<string>() : std::nullopt;
    std::vector<double> numbers;
    if (name)
      for (const auto& row : source.contact_.alternatives[i].scene.friction_map->rows)
        numbers.insert(numbers.end(), row.begin(), row.end());
    if (name) source.files_.push_back(*file_sum(*name, {numbers}));
  }
}

/// What sets ask of markers; the file of their places.
template <>
void SweepReaderOf<fem::PadScene>::take_markers(PadSource& source) const {
  constexpr double least_depth = 0.02;  // H: where the kernel's sums are still as good as cells
  const auto markers = source.markers();
  if (!markers) return;
  const auto table = file_.root()["markers"];
  for (const auto& sensor : source.sensors_)
    if (markers->depth < least_depth * sensor.thickness)
      throw file_.error("markers.depth", table["depth"].node(), "a fiftieth of sensor.thickness or more in sweeps");
  if (const auto name = table["places"].value<string>())
    source.files_.push_back(*file_sum(*name, {{markers->places.front().data(), 2 * markers->places.size()}}));
}

/// What sweeps of pads alone ask.
template <>
void SweepReaderOf<fem::Scene>::check_whole(SceneSource&) const {}
template <>
void SweepReaderOf<fem::PadScene>::check_whole(PadSource& source) const {
  check_holds(source);
  take_markers(source);
  take_maps(source);
}

template <class Scene>
void SweepReaderOf<Scene>::take_irregular(const toml::table& load, const toml::node& node, Alternative& into) const {
  const toml::table& table = table_of_path(load, node, "load.irregular");
  const auto& base = into.scene.load;
  if (const auto& targets = base.normal_force.empty() ? base.indentation : base.normal_force; targets.size() != 1)
    throw file_.error("load.irregular", &node, "given with one indentation or normal_force");
  into.irregular = read_irregular_load(file_, table, !of_lines<Scene>);
}

template <class Scene>
typename SweepReaderOf<Scene>::Part SweepReaderOf<Scene>::part(const string& name) {
  Part part{.alternatives = {}, .weights = {}, .number = next_++};
  const auto all = tables(name);
  static const toml::table nothing;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const toml::table& table = all[i] ? *all[i] : nothing;
    part.weights.push_back(weight(name, table));
    part.alternatives.push_back(alternative(name, i, table));
  }
  if (std::ranges::all_of(part.weights, [](double w) { return w == 0; }))
    throw file_.error(name + ".weight", nullptr, "above 0 for at least one [[" + name + "]]");
  return part;
}

/// Sensors of which every contact draws its own: on patches, and within what their tables serve.
template <>
void SweepReaderOf<fem::Scene>::read_own_sensors(SceneSource& source, SceneSource::Part&& part) {
  constexpr const char* instead = "; or [sweep] sensors = n, for n sensors that the contacts share";
  fem::SensorRange range{.poisson_low = 0.5, .poisson_high = 0, .longest = 0};
  double shortest = fem::longest_sensor;
  const auto all = tables("sensor");
  for (std::size_t i = 0; i < part.alternatives.size(); ++i) {
    const SceneSource::Alternative& from = part.alternatives[i];
    const auto node = [&](const char* key) { return all[i] ? all[i]->get(key) : nullptr; };
    if (from.scene.model != fem::SurfaceModel::patch)
      throw file_.error("sweep.sensors", nullptr, "a number of sensors to draw: each needs a condensation on a mesh");
    fem::Scene least = from.scene, most = from.scene;
    for (const SceneSource::NumberDraw& d : from.draws)
      d.put(least, ends(d.distribution).first), d.put(most, ends(d.distribution).second);
    if (!most.sensor.layers.empty())
      throw file_.error("sensor.layers", node("layers"),
                        string("left out where each contact draws its own sensor") + instead);
    if (most.sensor.tactel_width > 0)
      throw file_.error("sensor.tactel_width", node("tactel_width"),
                        string("0 where each contact draws its own sensor") + instead);
    if (!(most.sensor.poisson < 0.5))
      throw file_.error("sensor.poisson", node("poisson"),
                        string("below 0.5 where each contact draws its own sensor") + instead);
    range.tactels = from.scene.sensor.tactels;
    range.poisson_low = std::min(range.poisson_low, least.sensor.poisson);
    range.poisson_high = std::max(range.poisson_high, most.sensor.poisson);
    range.longest = std::max(range.longest, most.sensor.length / least.sensor.thickness);
    shortest = std::min(shortest, least.sensor.length / most.sensor.thickness);
    if (shortest < fem::shortest_of_family || range.longest > fem::longest_sensor)
      throw file_.error("sensor.length", node("length"),
                        fmt::format("always {} to {} times sensor.thickness where each contact draws its own sensor{}",
                                    fem::shortest_of_family, fem::longest_sensor, instead));
    source.sensors_.push_back(from.scene.sensor);
  }
  source.model_ = fem::SurfaceModel::patch;
  source.own_sensors_ = range;
  source.sensor_ = std::move(part);
}

/// The same on pads.
template <>
void SweepReaderOf<fem::PadScene>::read_own_sensors(PadSource& source, PadSource::Part&& part) {
  static const auto poisson = number_place<fem::PadScene>("sensor.poisson", ""),
                    thickness = number_place<fem::PadScene>("sensor.thickness", "");
  source.own_sensors_.emplace();
  const auto all = tables("sensor");
  for (std::size_t i = 0; i < part.alternatives.size(); ++i) {
    const PadSource::Alternative& from = part.alternatives[i];
    const bool own_sides =
        std::ranges::any_of(from.draws, [](const auto& d) { return d.place == poisson || d.place == thickness; });
    if (own_sides && fem::has_free_sides(from.scene.sensor))
      throw file_.error("sensor.sides", all[i] ? all[i]->get("sides") : nullptr,
                        "\"held\" where each contact draws its own thickness or Poisson's ratio: free sides of each "
                        "take tenths of a second; or [sweep] sensors = n, for n sensors that the contacts share");
    if (own_sides && from.scene.markers)
      throw file_.error("markers", file_.root().get("markers"),
                        "left out where each contact draws its own thickness or Poisson's ratio: tables of each take "
                        "tenths of a second; or [sweep] sensors = n, for n sensors that the contacts share");
    if (own_sides && from.scene.sensor.depth > 0)
      throw file_.error("sensor.depth", all[i] ? all[i]->get("depth") : nullptr,
                        "0 where each contact draws its own thickness or Poisson's ratio: tables of each take tenths "
                        "of a second; or [sweep] sensors = n, for n sensors that the contacts share");
    for (const PadSource::NumberDraw& d : from.draws) {
      const auto* choice = std::get_if<ChoiceDraw>(&d.distribution);
      source.own_sensors_->any_poisson |=
          d.place == poisson && (choice == nullptr || choice->values.size() > most_poissons);
    }
    source.sensors_.push_back(from.scene.sensor);
  }
  source.sensor_ = std::move(part);
}

/// Whether each contact draws its own of the numbers that tables of many sensors serve.
template <class Scene>
bool SweepReaderOf<Scene>::draws_own_sensors(const Part& part) const {
  const auto is_sensors = [](const NumberDraw& draw) {
    for (const char* key : {"sensor.poisson", "sensor.thickness", "sensor.young", "sensor.length"})
      if (draw.place == number_place<Scene>(key, "")) return true;
    return false;
  };
  return std::ranges::any_of(part.alternatives,
                             [&](const auto& from) { return std::ranges::any_of(from.draws, is_sensors); });
}

/// Sensors that are given stand as they are; one with distributions is drawn `count` times, or by each contact (count
/// 0).
template <class Scene>
void SweepReaderOf<Scene>::read_sensors(Source& source, int count) {
  Part part = this->part("sensor");
  source.inputs_ = inputs_of(part.alternatives[0].scene.sensor);
  for (std::size_t i = 0; i < part.alternatives.size(); ++i)
    if (inputs_of(part.alternatives[i].scene.sensor) != source.inputs_)
      throw file_.error("sensor.tactels", tables("sensor")[i]->get("tactels"), one_width);
  if (count == 0 && draws_own_sensors(part)) return read_own_sensors(source, std::move(part));
  if (count == 0) count = usual_sensors;
  for (std::size_t i = 0; i < part.alternatives.size(); ++i) {
    const Alternative& from = part.alternatives[i];
    if (source.model_ = model_of(from.scene); source.model_ != model_of(part.alternatives[0].scene))
      throw file_.error("sensor.model", nullptr, "the same for every [[sensor]], and a mesh named in all or in none");
    const int copies = from.draws.empty() ? 1 : count;
    for (int copy = 0; copy < copies; ++copy) {
      Scene scene = from.scene;
      for (const NumberDraw& d : from.draws)
        d.put(scene, draw(d.distribution,
                          {source.seed_, nn::RandomStream::sensor, static_cast<std::uint64_t>(copy), d.number}));
      fem::validate(scene.sensor);
      source.sensors_.push_back(scene.sensor);
      source.sensor_weights_.push_back(part.weights[i] / copies);
    }
  }
}

template <class Scene>
typename SweepReaderOf<Scene>::Source SweepReaderOf<Scene>::read() {
  TomlTable sweep(file_, "sweep");
  Source source;
  std::int64_t contacts = 0, seed = 0;
  int sensors = 0;
  sweep.refuse_unknown({"contacts", "seed", "sensors", "set", "press_rows"});
  if (!sweep.read("contacts", contacts, "a whole number of contacts, at least 1"))
    sweep.refuse_missing("contacts",
                         "given, a whole number of contacts (or set = \"paper-learning\"); a file without [sweep] is a "
                         "scene, for `tactel solve FILE`");
  if (contacts < 1 || contacts > most_contacts)
    sweep.refuse("contacts", "a whole number of contacts, 1 to " + std::to_string(most_contacts));
  if (sweep.read("seed", seed, "a whole number, at least 0") && seed < 0)
    sweep.refuse("seed", "a whole number, at least 0");
  if (sweep.read("sensors", sensors, "a whole number") && (sensors < 1 || sensors > most_sensors))
    sweep.refuse("sensors", "a number of sensors, 1 to 10000, drawn from a [sensor] with distributions");
  if (bool rows = false; sweep.read("press_rows", rows, press_rows_words)) source.give_press_rows(rows);
  sweep.finish();
  for (const char* part : part_names)
    tables(part);  // refuses what is no table, before one part is read with the others
  source.contacts_ = static_cast<std::uint64_t>(contacts);
  const std::uint64_t chosen = seed_.value_or(static_cast<std::uint64_t>(seed));
  source.measure_with(read_transducer(file_, chosen), chosen);
  source.file_ = file_.path().string();
  read_sensors(source, sensors);
  source.indenter_ = part("indenter");
  source.contact_ = part("contact");
  source.load_ = part("load");
  check_whole(source);
  source.lay_out_quantiles(next_);
  for (const Alternative& kind : source.indenter_.alternatives) {
    const auto& shape = kind.scene.indenter.shape;
    source.kind_names_.emplace_back(kind.profile ? "random profile" : fem::shape_name(shape));
    if (auto file = file_of(shape)) source.files_.push_back(std::move(*file));
  }
  return source;
}

template class SweepReaderOf<fem::Scene>;
template class SweepReaderOf<fem::PadScene>;

}  // namespace tactel::host
