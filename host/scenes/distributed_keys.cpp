// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/distributed_keys.h"

#include <algorithm>

#include "host/scenes/number_reader.h"
#include "host/scenes/scene_tables.h"

namespace tactel::host {
namespace {

template <class Scene>
struct Entry {
  std::string shape;  ///< empty: any
  std::string key;
  NumberPlace<Scene> place;
};

void set_number(double& number, int, double value) { number = value; }
void set_number(std::optional<double>& number, int, double value) { number.value() = value; }
template <class Several>
void set_number(Several& numbers, int index, double value) {
  numbers[static_cast<std::size_t>(index)] = value;
}

/// The part of a scene that has the numbers of T.
template <class T, class Scene>
T& part(Scene& scene) {
  if constexpr (std::is_same_v<T, decltype(scene.sensor)>)
    return scene.sensor;
  else if constexpr (std::is_same_v<T, decltype(scene.indenter)>)
    return scene.indenter;
  else if constexpr (std::is_same_v<T, decltype(scene.load)>)
    return scene.load;
  else
    return std::get<T>(scene.indenter.shape);
}

/// Adds what sweeps may draw of T, whose keys stand in this table.
template <class T, class Scene>
void add_drawn(std::vector<Entry<Scene>>& all, const std::string& table, const char* shape = "") {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    [[maybe_unused]] const auto add_one = [&]<std::size_t k>(std::integral_constant<std::size_t, k>) {
      constexpr auto number = std::get<k>(fem::numbers<T>);
      if constexpr (number.drawn)
        all.push_back({shape, table + "." + number.key, [](Scene& scene, int index, double value) {
                         set_number(part<T>(scene).*std::get<k>(fem::numbers<T>).member, index, value);
                       }});
    };
    (add_one(std::integral_constant<std::size_t, i>{}), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<std::remove_cvref_t<decltype(fem::numbers<T>)>>>{});
}
template <class Scene, class... Shapes>
void add_shapes(std::vector<Entry<Scene>>& all, const std::variant<Shapes...>&) {
  (add_drawn<Shapes>(all, "indenter", fem::shape_name(std::variant<Shapes...>(Shapes{}))), ...);
}

using S = fem::Scene;
using P = fem::PadScene;

const std::vector<Entry<S>>& entries(const S*) {
  static const std::vector<Entry<S>> all = [] {
    std::vector<Entry<S>> made;
    add_drawn<fem::Sensor>(made, "sensor");
    add_drawn<fem::Indenter>(made, "indenter");
    add_shapes(made, fem::Shape{});
    made.push_back({"", "contact.friction", [](S& s, int, double v) { s.friction = v; }});
    add_drawn<fem::Load>(made, "load");
    return made;
  }();
  return all;
}

/// One of equal steps: positions are its multiples.
void put_step(P& scene, int axis, double step) {
  for (std::size_t k = 0; k < scene.load.drags.size(); ++k)
    scene.load.drags[k][axis] = static_cast<double>(k + 1) * step;
}

const std::vector<Entry<P>>& entries(const P*) {
  static const std::vector<Entry<P>> all = [] {
    std::vector<Entry<P>> made;
    add_drawn<fem::PadSensor>(made, "sensor");
    add_drawn<fem::PadIndenter>(made, "indenter");
    add_shapes(made, fem::PadShape{});
    made.push_back({"", "contact.friction", [](P& s, int, double v) { s.friction = v; }});
    add_drawn<fem::PadLoad>(made, "load");
    const Entry<P> others[] = {
        {"", "load.tangential", [](P& s, int i, double v) { s.load.drags[i / 2][i % 2] = v; }},
        {"", "load.tangential_step", put_step},
        {"", "load.twist", [](P& s, int i, double v) { s.load.drags[i][2] = radians(v); }},
        {"", "load.twist_step", [](P& s, int, double v) { put_step(s, 2, radians(v)); }},
        {"", "load.times", [](P& s, int i, double v) { s.load.times[i] = v; }},
    };
    made.insert(made.end(), std::begin(others), std::end(others));
    return made;
  }();
  return all;
}

template <class Scene>
bool fits(const Entry<Scene>& entry, const std::string& shape) {
  if (entry.key.starts_with("indenter.tilt"))
    return std::ranges::any_of(shapes_of<fem::PadShape>(),
                               [&](const auto& s) { return s.name == shape && fem::tilts(s.made); });
  return entry.shape.empty() || entry.shape == shape;
}

}  // namespace

template <class Scene>
NumberPlace<Scene> number_place(const std::string& key, const std::string& shape) {
  const std::vector<Entry<Scene>>& all = entries(static_cast<const Scene*>(nullptr));
  const auto found = std::ranges::find_if(all, [&](const auto& e) { return e.key == key && fits(e, shape); });
  return found == all.end() ? nullptr : found->place;
}

template <class Scene>
std::vector<std::string> drawable_keys(const std::string& table, const std::string& shape) {
  std::vector<std::string> keys;
  for (const Entry<Scene>& entry : entries(static_cast<const Scene*>(nullptr)))
    if (entry.key.starts_with(table + ".") && fits(entry, shape)) keys.push_back(entry.key.substr(table.size() + 1));
  return keys;
}

template NumberPlace<S> number_place(const std::string&, const std::string&);
template NumberPlace<P> number_place(const std::string&, const std::string&);
template std::vector<std::string> drawable_keys<S>(const std::string&, const std::string&);
template std::vector<std::string> drawable_keys<P>(const std::string&, const std::string&);

}  // namespace tactel::host
