// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/sweep_file.h"

#include <toml++/toml.h>

#include <sstream>

#include "host/scenes/scene_tables.h"
#include "host/scenes/sweep_reader.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

/// The paper's choices with `preset = "paper"`, else the sensor that scene files start from; the load is the sets' own.
fem::Scene base_scene(const TomlFile& file) {
  TomlTable root(file, "");
  fem::Scene base = paper_set_scene();
  if (!root.read_choice("preset", {"paper"})) base.sensor = {};
  read_title(root, base.title);
  for (const char* table : {"sweep", "transducer", "sensor", "contact", "load"}) root.expect_table(table);
  if (root.has("indenter")) root.refuse("indenter", "left out: sweep.set determines the indenters");
  root.finish();
  read_sensor(file, base, fem::SurfaceModel::mesh);
  read_contact(file, base.friction);
  read_load(file, base.load, true);
  return base;
}

AnySource paper_source(const TomlFile& file, std::optional<std::uint64_t> given_seed) {
  const std::vector<std::string> sets = {"paper-learning", "paper-recall"};
  const fem::Scene base = base_scene(file);
  TomlTable in(file, "sweep");
  const std::size_t set = in.read_choice("set", sets).value();
  double scale = 10.0, height = 10.0;
  std::int64_t seed = 0;
  if (in.read("seed", seed, "a whole number, at least 0") && seed < 0) in.refuse("seed", "a whole number, at least 0");
  if (set == 0) {
    in.read("scale", scale, "a number of mm above 0");
    in.read("height", height, "a number of mm above 0");
  }
  bool press_rows = false;
  in.read("press_rows", press_rows, press_rows_words);
  in.finish();
  try {
    SceneSource source = source_of(set == 0 ? paper_learning_family(base, scale, height) : paper_recall_family(base));
    const std::uint64_t chosen = given_seed.value_or(static_cast<std::uint64_t>(seed));
    source.give_press_rows(press_rows);
    source.measure_with(read_transducer(file, chosen), chosen);
    return source;
  } catch (const ValueError& error) {
    throw file.error(error);
  }
}

/// The kind of the first sensor.
bool draws_pads(const TomlFile& file) {
  const toml::node* node = file.root().get("sensor");
  if (node != nullptr && node->is_array()) node = node->as_array()->get(0);
  const toml::table* sensor = node != nullptr ? node->as_table() : nullptr;
  return sensor != nullptr && (*sensor)["kind"].value<std::string>() == "pad";
}

Sweep sweep_of(TomlFile file, std::optional<std::uint64_t> seed) {
  std::string text = file.text();
  if (TomlTable(file, "sweep").has("set")) return {std::move(text), paper_source(file, seed)};
  if (draws_pads(file)) return {std::move(text), SweepReaderOf<fem::PadScene>(std::move(file), seed).read()};
  return {std::move(text), SweepReaderOf<fem::Scene>(std::move(file), seed).read()};
}

/// Of a pad so many tactels along each side, on the area that the file's tactels share.
void put_tactels(toml::table& sensor, int tactels) {
  if (sensor["kind"].value_or(std::string_view()) != "pad") return void(sensor.insert_or_assign("tactels", tactels));
  const fem::PadSensor usual;
  toml::array pitch;
  for (std::size_t axis : {0, 1}) {
    const auto& node = sensor["pitch"];
    const double before = node.is_array() ? node[axis].value_or(usual.pitch[axis]) : node.value_or(usual.pitch[axis]);
    pitch.push_back(before * sensor["tactels"][axis].value_or(usual.tactels[axis]) / tactels);
  }
  sensor.insert_or_assign("tactels", toml::array{tactels, tactels});
  sensor.insert_or_assign("pitch", std::move(pitch));
}

}  // namespace

const SceneSource& Sweep::lines(const std::string& file) const {
  if (const auto* of_lines = std::get_if<SceneSource>(&source)) return *of_lines;
  throw ConfigError(file, "sensor.kind", "\"pad\"", "\"line\": this takes no pads");
}

Sweep read_sweep(const std::filesystem::path& path, std::optional<std::uint64_t> seed) {
  return sweep_of(TomlFile(path), seed);
}

Sweep read_sweep_text(const std::filesystem::path& path, std::string text, std::optional<std::uint64_t> seed) {
  return sweep_of(TomlFile(path, std::move(text)), seed);
}

Sweep read_sweep_of_sensor(const std::filesystem::path& path, std::optional<std::uint64_t> seed,
                           std::optional<int> tactels, std::optional<double> thickness) {
  if (!tactels && !thickness) return read_sweep(path, seed);
  TomlFile file(path);
  toml::table& root = file.root();
  toml::table* sensor = root.emplace<toml::table>("sensor").first->second.as_table();
  if (sensor == nullptr) return read_sweep(path, seed);  // which names the fault
  if (tactels) put_tactels(*sensor, *tactels);
  if (thickness) sensor->insert_or_assign("thickness", *thickness);
  std::ostringstream text;
  text << root;
  return read_sweep_text(path, text.str(), seed);
}

}  // namespace tactel::host
