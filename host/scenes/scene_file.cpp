// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/scene_file.h"

#include <algorithm>
#include <array>
#include <limits>

#include "host/scenes/number_reader.h"
#include "host/scenes/pad_file.h"
#include "host/scenes/scene_tables.h"
#include "host/scenes/shape_reader.h"
#include "host/scenes/toml_table.h"

namespace tactel::host {
namespace {

const std::string left_out_of_a_line = std::string("left out: it ") + of_a_pad;

}  // namespace

void read_sensor(const TomlFile& file, fem::Scene& scene, fem::SurfaceModel usual) {
  TomlTable in(file, "sensor");
  if (in.read_choice("kind", sensor_kinds) == 1u)
    in.refuse("kind", "\"line\" here: scenes of pads are for solve, simulate: and tactel.calibrate");
  in.refuse_any({"pitch", "tactel_size", "axes", "width", "relaxation", "depth"}, left_out_of_a_line);
  const bool names_mesh = std::ranges::any_of(std::array{"columns", "rows", "grading", "element", "stress"},
                                              [&](const char* key) { return in.has(key); });
  const auto model = in.read_choice("model", {"auto", "mesh", "patch"});
  if (names_mesh && model == 2u) in.refuse("model", "auto or mesh, because the table names a mesh");
  scene.model = names_mesh || model == 1u ? fem::SurfaceModel::mesh : model == 2u ? fem::SurfaceModel::patch : usual;
  read_numbers(in, scene.sensor, false);
  read_layers(in, scene.sensor);
  in.finish();
}

void read_contact(const TomlFile& file, double& friction) {
  TomlTable in(file, "contact");
  in.refuse_any({"friction_map", "friction_pitch"}, left_out_of_a_line);
  const char* allowed = "a number, mu >= 0, or \"bonded\"";
  if (in.has_text("friction")) {
    std::string word;
    in.read("friction", word, allowed);
    if (word != "bonded") in.refuse("friction", allowed);
    friction = std::numeric_limits<double>::infinity();
  } else {
    in.read("friction", friction, allowed);
  }
  in.finish();
}

namespace {

void read_normal_load(TomlTable& in, fem::Load& load, bool preset) {
  in.refuse_any({"twist", "twist_step"}, left_out_of_a_line);
  in.refuse_unknown({"indentation", "normal_force", "indentation_steps", "tangential_step", "tangential_steps",
                     "tangential", "angle"});
  read_pressing(in, load, !preset);
}

void read_tangential_load(TomlTable& in, fem::Load& load, bool preset) {
  const std::string given = in.only_one({"tangential_step", "tangential", "angle"});
  if (given == "tangential" || given == "angle") {
    load.tangential_step = 0.0;
    load.tangential_steps.reset();
  }
  const bool stepping = given == "tangential_step" || (given.empty() && preset);
  if (in.has("tangential_steps") && !stepping)
    in.refuse("tangential_steps", "left out, or given together with load.tangential_step");
  in.read("tangential_step", load.tangential_step, "a number of mm");
  if (int steps = 0;
      in.read("tangential_steps", steps,
              "a whole number of steps, at least 1 (without it the drag lasts until the whole contact slides)")) {
    load.tangential_steps = steps;
  }
  in.read("tangential", load.tangential, "an array of positions in mm");
  if (in.has("tangential") && load.tangential.empty())
    in.refuse("tangential", "an array of at least one position in mm");
  if (double angle = 0; in.read("angle", angle, "a number of degrees, with load.normal_force")) {
    if (!in.has("normal_force")) in.refuse("angle", "left out, or given together with load.normal_force");
    load.angle = angle;
  }
}

}  // namespace

void read_title(TomlTable& root, std::string& title) {
  root.read("title", title, "a text");
  try {
    check_title(title);
  } catch (const ValueError& error) {
    root.refuse("title", error.allowed);
  }
}

void read_load(const TomlFile& file, fem::Load& load, bool preset) {
  TomlTable in(file, "load");
  read_normal_load(in, load, preset);
  read_tangential_load(in, load, preset);
  in.finish();
}

fem::Scene paper_preset() {
  fem::Scene scene;
  scene.sensor.poisson = 0.49;
  scene.sensor.grading = 2.75;
  scene.sensor.element = fem::Element::q4i;
  scene.sensor.stress = fem::StressRecovery::element;
  scene.indenter.shape = fem::Parabola{.radius = 97.0};
  scene.friction = 0.4;
  scene.load.indentation = {0.15};
  scene.load.indentation_steps = 10;
  scene.load.tangential_step = 0.075;
  scene.load.tangential_steps = 4;
  return scene;
}

namespace {

fem::Scene read_line(const TomlFile& file) {
  TomlTable root(file, "");
  fem::Scene scene;
  read_title(root, scene.title);
  const bool preset = root.read_choice("preset", {"paper"}).has_value();
  if (preset) {
    std::string title = std::move(scene.title);
    scene = paper_preset();
    scene.title = std::move(title);
  }
  for (const char* table : {"sensor", "indenter", "contact", "load"}) root.expect_table(table);
  if (root.has("sweep"))
    root.refuse("sweep", "left out of a scene; a file with [sweep] is for `tactel generate FILE --output SET.h5`");
  root.finish();
  read_sensor(file, scene, preset ? fem::SurfaceModel::mesh : usual_model);
  read_indenter(file, scene.indenter, preset);
  read_contact(file, scene.friction);
  read_load(file, scene.load, preset);
  try {
    scene.validate();
  } catch (const ValueError& error) {
    throw file.error(error);
  }
  return scene;
}

}  // namespace

fem::Scene read_scene(const std::filesystem::path& path) { return read_line(TomlFile(path)); }

AnyScene read_any_scene(const std::filesystem::path& path) {
  const TomlFile file(path);
  if (is_pad(file)) return read_pad(file);
  return read_line(file);
}

}  // namespace tactel::host
