// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/pad_file.h"

#include "fem/pad/side_kernel.h"
#include "host/scenes/number_reader.h"
#include "host/scenes/profile_csv.h"
#include "host/scenes/scene_tables.h"

namespace tactel::host {
namespace {

const std::string left_out_of_a_pad = std::string("left out: it ") + of_a_line;

void read_pad_sensor(const TomlFile& file, fem::PadSensor& sensor) {
  TomlTable in(file, "sensor");
  in.refuse_any({"model", "columns", "rows", "grading", "element", "stress", "tactel_span", "tactel_width"},
                left_out_of_a_pad);
  in.read_choice("kind", sensor_kinds);
  const bool thick = in.has("thickness") || in.has("layers"), sides = in.has("sides");
  read_numbers(in, sensor, false);
  read_layers(in, sensor);
  in.read("relaxation", sensor.relaxation, "an array of pairs [share of E, seconds]");
  if (sides && sensor.sides == fem::Sides::free && !(sensor.length && sensor.width))
    in.refuse("sides", "\"held\", or given with sensor.length and sensor.width, between which sides are free");
  in.finish();
  if (!thick) in.refuse_missing("thickness", "given, the thickness of the rubber in mm");
}

template <class S>
void read_pad_shape(TomlTable& in, const TomlFile&, S& shape) {
  read_numbers(in, shape, true);
}
void read_pad_shape(TomlTable& in, const TomlFile& file, fem::HeightMap& map) {
  const auto need = [&](const char* key, auto& value, const std::string& what) {
    if (!in.read(key, value, what)) in.refuse_missing(key, "given, " + what);
  };
  std::string name;
  need("pitch", map.pitch, "the distance of the grid's points in mm");
  need("file", name, "the name of a CSV file with a grid of heights in mm");
  const std::filesystem::path path = file.path().parent_path() / name;
  read_heights_csv(path, map);
  map.file = path.string();
}

void read_pad_indenter(const TomlFile& file, fem::PadIndenter& indenter) {
  TomlTable in(file, "indenter");
  refuse_other_kind<fem::PadShape, fem::Shape>(in, {}, of_a_line);
  indenter.shape = choose_shape<fem::PadShape>(in, {"shape", "position", "yaw", "young", "poisson"}).made;
  std::visit([&](auto& shape) { read_pad_shape(in, file, shape); }, indenter.shape);
  read_numbers(in, indenter, false);
  if (in.has("poisson") && !indenter.young) in.refuse("poisson", "left out, or given with indenter.young");
  in.finish();
}

void read_pad_friction(const TomlFile& file, fem::PadScene& scene) {
  TomlTable in(file, "contact");
  if (in.has_text("friction")) in.refuse("friction", "a number, 0 to 100: of a line alone it may be \"bonded\"");
  in.read("friction", scene.friction, "a number, 0 to 100");
  in.only_one({"friction", "friction_map"});
  FrictionMap map;
  const char* words = "the name of a CSV file with mu, or rows [[mu, ...], ...], one for each y";
  const bool spaced = in.read("friction_pitch", map.pitch, "the distance of the map's nodes in mm");
  if (std::string name; in.has_text("friction_map") && in.read("friction_map", name, words))
    read_friction_csv(file.path().parent_path() / name, map);
  else
    in.read("friction_map", map.rows, words);
  in.finish();
  if (spaced || in.has("friction_map")) scene.set_friction(std::move(map));
}

/// Drags in equal steps.
void read_drag_steps(TomlTable& in, fem::PadLoad& load) {
  std::array<double, 2> step{};
  double twist = 0;
  int steps = 0;
  const bool moves = in.read("tangential_step", step, "two numbers [dx, dy] of mm");
  const bool turns = in.read("twist_step", twist, "a number of degrees");
  const char* number = "a whole number of steps, 1 to 1000";
  const bool counted = in.read("tangential_steps", steps, number);
  if (counted && !moves && !turns)
    in.refuse("tangential_steps", "left out, or given together with load.tangential_step or load.twist_step");
  if (!moves && !turns) return;
  if (!counted) in.refuse_missing("tangential_steps", std::string("given, ") + number);
  if (steps < 1 || steps > 1000) in.refuse("tangential_steps", number);
  for (int k = 1; k <= steps; ++k) load.drags.push_back({k * step[0], k * step[1], radians(k * twist)});
}

/// Drags to positions.
void read_drag_positions(TomlTable& in, fem::PadLoad& load) {
  std::vector<std::array<double, 2>> places;
  std::vector<double> twists;
  const char *words = "an array of positions [x, y] in mm, at least one", *turns = "an array of degrees, at least one";
  const bool moves = in.read("tangential", places, words), twisted = in.read("twist", twists, turns);
  if (moves && places.empty()) in.refuse("tangential", words);
  if (twisted && twists.empty()) in.refuse("twist", turns);
  if (moves && twisted && twists.size() != places.size())
    in.refuse("twist", "as many numbers of degrees as load.tangential has positions, " + std::to_string(places.size()));
  places.resize(std::max(places.size(), twists.size()));
  twists.resize(places.size());
  for (std::size_t k = 0; k < places.size(); ++k)
    load.drags.push_back({places[k][0], places[k][1], radians(twists[k])});
}

void read_pad_load(const TomlFile& file, fem::PadLoad& load) {
  TomlTable in(file, "load");
  in.refuse_any({"angle"}, left_out_of_a_pad);
  in.refuse_unknown({"indentation", "normal_force", "indentation_steps", "tangential", "twist", "tangential_step",
                     "twist_step", "tangential_steps", "times"});
  read_pressing(in, load, true);
  for (const char* step : {"tangential_step", "twist_step"})
    for (const char* position : {"tangential", "twist"}) in.only_one({position, step});
  read_drag_steps(in, load);
  read_drag_positions(in, load);
  in.read("times", load.times, "an array of s, one for each load step");
  in.finish();
}

void read_markers(const TomlFile& file, std::optional<Markers>& markers) {
  TomlTable in(file, "markers");
  markers.emplace();
  const char* places = "the name of a CSV file with x and y in mm, or an array of places [x, y], at least one";
  if (in.has("places"))
    for (const char* grid : {"counts", "pitch"}) in.only_one({"places", grid});
  read_numbers(in, *markers, false);
  if (std::string name; in.has_text("places") && in.read("places", name, places))
    read_places_csv(file.path().parent_path() / name, markers->places);
  else if (in.read("places", markers->places, places) && markers->places.empty())
    in.refuse("places", places);
  in.finish();
}

void read_camera(const TomlFile& file, std::optional<Camera>& camera) {
  TomlTable in(file, "camera");
  read_numbers(in, camera.emplace(), false);
  in.finish();
}

}  // namespace

bool is_pad(const TomlFile& file) { return TomlTable(file, "sensor").read_choice("kind", sensor_kinds) == 1u; }

fem::PadScene read_pad(const TomlFile& file) {
  TomlTable root(file, "");
  fem::PadScene scene;
  read_title(root, scene.title);
  root.refuse_any({"preset"}, left_out_of_a_pad);
  root.refuse_any({"sweep"}, "left out: a scene is one contact; `tactel generate` takes sweeps");
  for (const char* table : {"sensor", "indenter", "contact", "load", "markers", "camera"}) root.expect_table(table);
  root.finish();
  read_pad_sensor(file, scene.sensor);
  read_pad_indenter(file, scene.indenter);
  read_pad_friction(file, scene);
  read_pad_load(file, scene.load);
  if (root.has("markers")) read_markers(file, scene.markers);
  if (root.has("camera")) read_camera(file, scene.camera);
  try {
    scene.validate();
  } catch (const ValueError& error) {
    throw file.error(error);
  }
  return scene;
}

}  // namespace tactel::host
