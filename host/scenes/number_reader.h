// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "fem/scenes/scene_numbers.h"
#include "host/scenes/toml_table.h"
#include "host/support/nearest_word.h"

namespace tactel::host {

// Reading the numbers of a struct as its table has them (fem/scenes/scene_numbers.h). Each function returns whether the
// key is there.

template <class Value>
bool read_number(TomlTable& in, const char* key, Value& value, const char* allowed) {
  return in.read(key, value, allowed);
}
/// One number stands for both axes of a pitch.
inline bool read_number(TomlTable& in, const char* key, std::array<double, 2>& value, const char* allowed) {
  if (key != std::string_view("pitch")) return in.read(key, value, allowed);
  std::vector<double> both;
  if (!in.read_one_or_more(key, both, allowed)) return false;
  if (both.size() > 2) in.refuse(key, allowed);
  value = {both.front(), both.back()};
  return true;
}
inline bool read_number(TomlTable& in, const char* key, std::optional<double>& value, const char* allowed) {
  double number = 0;
  const bool there = in.read(key, number, allowed);
  if (there) value = number;
  return there;
}
inline bool read_number(TomlTable& in, const char* key, std::array<int, 2>& value, const char* allowed) {
  std::vector<int> both;
  if (!in.read(key, both, allowed)) return false;
  if (both.size() != 2) in.refuse(key, allowed);
  value = {both[0], both[1]};
  return true;
}
template <class Word>
bool read_word(TomlTable& in, const char* key, Word& value, std::initializer_list<Word> all) {
  std::vector<std::string> names;
  for (const Word word : all) names.emplace_back(fem::name(word));
  const auto choice = in.read_choice(key, names);
  if (choice) value = all.begin()[*choice];
  return choice.has_value();
}
inline bool read_number(TomlTable& in, const char* key, fem::Element& value, const char*) {
  return read_word(in, key, value, {fem::Element::bbar, fem::Element::q4, fem::Element::q4i, fem::Element::q8});
}
inline bool read_number(TomlTable& in, const char* key, fem::StressRecovery& value, const char*) {
  return read_word(in, key, value, {fem::StressRecovery::reaction, fem::StressRecovery::element});
}
inline bool read_number(TomlTable& in, const char* key, fem::Sides& value, const char*) {
  return read_word(in, key, value, {fem::Sides::free, fem::Sides::held});
}

/// Reads the numbers of a struct. Where it is `complete`, those that are needed must be there.
template <class T>
void read_numbers(TomlTable& in, T& into, bool complete) {
  fem::each_number<T>([&](const auto& number) {
    const bool there = read_number(in, number.key, into.*number.member, number.allowed);
    if (!there && number.needed && complete) in.refuse_missing(number.key, std::string("given, ") + number.allowed);
  });
}

/// Reads the layers of a sensor, which have its thickness, young and poisson.
template <class Sensor>
void read_layers(TomlTable& in, Sensor& sensor) {
  const char* tables = "tables [[sensor.layers]] of thickness, young and poisson, base first";
  for (TomlTable& layer : in.read_tables("layers", tables))
    read_numbers(layer, sensor.layers.emplace_back(), true), layer.finish();
  if (sensor.layers.empty()) return;
  in.refuse_any({"thickness", "young", "poisson"}, "left out beside sensor.layers");
  const Sensor usual;  // a preset may have others
  sensor.thickness = usual.thickness, sensor.young = usual.young, sensor.poisson = usual.poisson;
  sensor = with_layers(std::move(sensor));
}

/// Reads the pressing of a load, by depth or by force; where it is `needed`, one of them must be there.
template <class Load>
void read_pressing(TomlTable& in, Load& load, bool needed) {
  const auto& all = fem::numbers<Load>;
  const auto &depth = std::get<0>(all), &force = std::get<1>(all);
  const auto& steps = std::get<2>(all);
  const std::string given = in.only_one({depth.key, force.key});
  if (given.empty() && needed)
    in.refuse_missing(depth.key,
                      std::string("given, a number of mm (or load.normal_force, a number of ") + force.unit + ")");
  if (given == force.key) load.indentation.clear();
  for (const auto* targets : {&depth, &force})
    in.read_one_or_more(targets->key, load.*targets->member, targets->allowed);
  in.read(steps.key, load.indentation_steps, steps.allowed);
}

/// A shape of indenters: its word in files, its keys besides those of all shapes, and its defaults.
template <class Shape>
struct ShapeName {
  std::string name;
  std::vector<std::string> keys;
  Shape made;
};

template <class S>
std::vector<std::string> keys_of_shape(bool tilts) {
  if (std::is_same_v<S, fem::Profile>) return {"x", "y", "file", "smooth"};
  if (std::is_same_v<S, fem::HeightMap>) return {"file", "pitch"};
  std::vector<std::string> keys;
  fem::each_number<S>([&](const auto& number) { keys.emplace_back(number.key); });
  if (tilts) keys.insert(keys.end(), {"tilt", "tilt_direction"});
  return keys;
}

/// Returns the shapes of a kind of sensor: fem::Shape or fem::PadShape.
template <class Shape>
const std::vector<ShapeName<Shape>>& shapes_of() {
  static const auto all = []<class... S>(const std::variant<S...>&) {
    return std::vector<ShapeName<Shape>>{
        {fem::shape_name(Shape(S{})), keys_of_shape<S>(fem::tilts(Shape(S{}))), S{}}...};
  }(Shape{});
  return all;
}

/// Refuses keys and shapes of [indenter] that the other kind of sensor has, and this one lacks. `others`: keys of all
/// shapes of the other kind. `is`: "belongs to a pad".
template <class Own, class Other>
void refuse_other_kind(TomlTable& in, const std::vector<std::string>& others, const std::string& is) {
  std::vector<std::string> known, foreign = others;
  for (const auto& shape : shapes_of<Own>()) known.insert(known.end(), shape.keys.begin(), shape.keys.end());
  for (const auto& shape : shapes_of<Other>()) foreign.insert(foreign.end(), shape.keys.begin(), shape.keys.end());
  std::erase_if(foreign, [&](const std::string& key) { return std::ranges::find(known, key) != known.end(); });
  in.refuse_any(foreign, "left out: it " + is);
  std::string word;
  if (!in.has_text("shape") || !in.read("shape", word, "")) return;
  const auto has = [&](const auto& shapes) {
    return std::ranges::any_of(shapes, [&](const auto& shape) { return shape.name == word; });
  };
  if (has(shapes_of<Other>()) && !has(shapes_of<Own>())) in.refuse("shape", "another one: it " + is);
}

/// Reads the key `shape` of [indenter] and returns its entry of shapes_of<Shape>(); `usual` where the key is absent.
/// Throws ConfigError where both are, and for keys that belong to another shape or to none; `common`: the keys of all
/// shapes.
template <class Shape>
const ShapeName<Shape>& choose_shape(TomlTable& in, const std::vector<std::string>& common,
                                     const Shape* usual = nullptr) {
  const std::vector<ShapeName<Shape>>& shapes = shapes_of<Shape>();
  std::vector<std::string> names, all = common;
  for (const auto& shape : shapes) {
    names.push_back(shape.name);
    all.insert(all.end(), shape.keys.begin(), shape.keys.end());
  }
  const auto choice = in.read_choice("shape", names);
  if (!choice && usual == nullptr) in.refuse_unknown(all);
  if (!choice && usual == nullptr) in.refuse_missing("shape", "given, one of " + listed(names));
  const ShapeName<Shape>& chosen = shapes[choice ? *choice : usual->index()];
  const auto holds = [](const std::vector<std::string>& keys, const std::string& key) {
    return std::ranges::find(keys, key) != keys.end();
  };
  for (const std::string& key : in.keys()) {
    if (holds(chosen.keys, key) || holds(common, key)) continue;
    std::vector<std::string> owners;
    for (const auto& shape : shapes)
      if (holds(shape.keys, key)) owners.push_back(shape.name);
    if (owners.empty()) continue;
    in.refuse(key, "left out: it belongs to shape " + listed(owners) + "; the keys of shape " + chosen.name + " are " +
                       listed(chosen.keys));
  }
  std::vector<std::string> known = common;
  known.insert(known.end(), chosen.keys.begin(), chosen.keys.end());
  in.refuse_unknown(known);
  return chosen;
}

}  // namespace tactel::host
