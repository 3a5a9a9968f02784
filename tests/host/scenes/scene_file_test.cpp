// SPDX-License-Identifier: Apache-2.0

// Scene files that are good: every key, defaults, the preset, profiles, and the scene written back as JSON.
#include "host/scenes/scene_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "fem/scenes/scene_numbers.h"
#include "host/scenes/scene_json.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"
#include "tests/thrown_message.h"

namespace tactel::host::scene_file_test {

fem::Scene read_text(const std::string& text) {
  const ScratchFolder folder;
  return read_scene(folder.write("scene.toml", text));
}

fem::Shape shape_of(const std::string& lines) {
  return read_text("[indenter]\n" + lines + "\n[load]\nindentation = 0.1\n").indenter.shape;
}

fem::Load load_of(const std::string& lines) {
  return read_text("[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\n" + lines + "\n").load;
}

TEST(SceneFile, EveryKey) {
  const fem::Scene scene = read_text(R"(title = "all of it"
[sensor]
length = 18.0
thickness = 2.5
young = 3.5
poisson = 0.3
columns = 31
rows = 9
grading = 2.0
element = "q8"
tactels = 8
stress = "element"
[indenter]
shape = "cylinder"
radius = 7.0
position = -1.25
[contact]
friction = 0.7
[load]
indentation = 0.2
indentation_steps = 3
tangential_step = -0.02
tangential_steps = 6
)");
  EXPECT_EQ(scene.title, "all of it");
  const fem::Sensor expected{.length = 18.0,
                             .thickness = 2.5,
                             .young = 3.5,
                             .poisson = 0.3,
                             .columns = 31,
                             .rows = 9,
                             .grading = 2.0,
                             .element = fem::Element::q8,
                             .tactels = 8,
                             .tactel_span = {},
                             .stress = fem::StressRecovery::element};
  EXPECT_EQ(scene.sensor, expected);
  EXPECT_EQ(std::get<fem::Cylinder>(scene.indenter.shape).radius, 7.0);
  EXPECT_EQ(scene.indenter.position, -1.25);
  EXPECT_EQ(scene.friction, 0.7);
  EXPECT_EQ(scene.load.indentation, std::vector{0.2});
  EXPECT_EQ(scene.load.indentation_steps, 3);
  EXPECT_EQ(scene.load.tangential_step, -0.02);
  EXPECT_EQ(scene.load.tangential_steps, 6);
}

TEST(SceneFile, LayersStandForTheNumbersOfTheirSum) {
  const std::string rest = "[indenter]\nshape = \"flat\"\n[load]\nindentation = 0.1\n",
                    layers =
                        "[[sensor.layers]]\nthickness = 1.2\nyoung = 1\n[[sensor.layers]]\nthickness = 0.3\n"
                        "young = 10\npoisson = 0.48\n";
  const fem::Scene scene = read_text(layers + rest);
  EXPECT_EQ(scene.sensor.layers, (std::vector<RubberLayer>{{1.2, 1, 0.45}, {0.3, 10, 0.48}}));
  EXPECT_EQ(std::tuple(scene.sensor.thickness, scene.sensor.young, scene.sensor.poisson), std::tuple(1.5, 10.0, 0.48));
  const auto sensor = to_json(scene)["sensor"];
  EXPECT_EQ(sensor["layers"][1]["young"], 10);
  EXPECT_FALSE(sensor.contains("thickness") || sensor.contains("young") || sensor.contains("poisson"));
  const ScratchFolder folder;
  EXPECT_EQ(read_scene(folder.write("back.toml", scene_toml(scene))).sensor, fem::with_span(scene.sensor));
  // The preset's own poisson gives way.
  EXPECT_EQ(read_text("preset = \"paper\"\n" + layers).sensor.layers, scene.sensor.layers);
  EXPECT_THAT(thrown_message<ConfigError>([&] { read_text("[sensor]\nyoung = 3\n" + layers + rest); }),
              testing::HasSubstr("sensor.young = 3: must be left out beside sensor.layers"));
  EXPECT_THAT(thrown_message<ConfigError>([&] { read_text("[sensor]\nrows = 2\n" + layers + rest); }),
              testing::HasSubstr("sensor.rows"));
}

TEST(SceneFile, WhatIsLeftOutTakesItsDefault) {
  const fem::Scene scene = read_text("[indenter]\nshape = \"flat\"\n[load]\nindentation = 1e-1\n");
  EXPECT_EQ(scene.sensor, fem::Sensor{});
  EXPECT_EQ(scene.friction, 0.5);
  EXPECT_EQ(scene.indenter.position, 0.0);
  EXPECT_EQ(scene.load.indentation_steps, 1);
  EXPECT_EQ(fem::load_path(scene.load).steps.size(), 1u);
}

TEST(SceneFile, EveryShape) {
  EXPECT_FALSE(std::get<fem::Flat>(shape_of("shape = \"flat\"")).half_width);
  EXPECT_EQ(std::get<fem::Flat>(shape_of("shape = \"flat\"\nhalf_width = 3")).half_width, 3.0);
  EXPECT_EQ(std::get<fem::Wedge>(shape_of("shape = \"wedge\"\nedge_angle = 150")).edge_angle, 150.0);
  EXPECT_EQ(std::get<fem::Parabola>(shape_of("shape = \"parabola\"\nradius = 97")).radius, 97.0);
  const auto exponential = std::get<fem::Exponential>(shape_of("shape = \"exponential\"\nheight = 0.2\nrate = 0.9"));
  EXPECT_EQ(exponential.height, 0.2);
  EXPECT_EQ(exponential.rate, 0.9);
  const auto trapezoid = std::get<fem::Trapezoid>(shape_of("shape = \"trapezoid\"\nhalf_width = 1.5\nslope = 0.4"));
  EXPECT_EQ(trapezoid.half_width, 1.5);
  EXPECT_EQ(trapezoid.slope, 0.4);
  const auto rounded = std::get<fem::RoundedFlat>(shape_of("shape = \"rounded_flat\"\nhalf_width = 1\nradius = 4"));
  EXPECT_EQ(rounded.half_width, 1.0);
  EXPECT_EQ(rounded.radius, 4.0);
  const auto taylor = std::get<fem::Taylor>(shape_of("shape = \"taylor\"\npowers = [1, 3]\nscale = 10"));
  EXPECT_EQ(taylor.powers, (std::vector{1, 3}));
  EXPECT_EQ(taylor.scale, 10.0);
  EXPECT_TRUE(std::get<fem::Taylor>(shape_of("shape = \"taylor\"\npowers = []")).powers.empty());
  const auto profile = std::get<fem::Profile>(shape_of("shape = \"profile\"\nx = [-1, 0, 1]\ny = [0.2, 0, 0.2]"));
  EXPECT_EQ(profile.x, (std::vector{-1.0, 0.0, 1.0}));
  EXPECT_EQ(profile.y, (std::vector{0.2, 0.0, 0.2}));
}

TEST(SceneFile, FrictionMayBeBonded) {
  const std::string rest = "[indenter]\nshape = \"flat\"\n[load]\nindentation = 0.1\n";
  const fem::Scene scene = read_text("[contact]\nfriction = \"bonded\"\n" + rest);
  EXPECT_TRUE(std::isinf(scene.friction) && scene.friction > 0);
  EXPECT_EQ(to_json(scene)["contact"]["friction"], "bonded");
  EXPECT_EQ(read_text("[contact]\nfriction = 0.25\n" + rest).friction, 0.25);
}

// 2^63 - 1 and 2^53 + 1 are no numbers of fp64: the nearest are 2^63 and 2^53.
TEST(SceneFile, WholeNumbersOfAnySizeAreNumbers) {
  const std::string scene = "[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.1\n[contact]\n";
  EXPECT_EQ(read_text(scene + "friction = 9223372036854775807\n").friction, 0x1p63);
  EXPECT_EQ(read_text(scene + "friction = 9007199254740993\n").friction, 0x1p53);
  EXPECT_EQ(load_of("normal_force = [1, 9007199254740993]").normal_force, (std::vector{1, 0x1p53}));
  EXPECT_THROW(read_text(scene + "friction = -9223372036854775808\n"), ConfigError);
  EXPECT_THROW(read_text(scene + "friction = true\n"), ConfigError);
}

TEST(SceneFile, LoadsMayBeSequences) {
  EXPECT_EQ(load_of("indentation = [0.15, 0.05, 0.15]").indentation, (std::vector{0.15, 0.05, 0.15}));
  const fem::Load force = load_of("normal_force = [1, 0.5]\nangle = 10");
  EXPECT_TRUE(force.indentation.empty());
  EXPECT_EQ(force.normal_force, (std::vector{1.0, 0.5}));
  EXPECT_EQ(force.angle, 10.0);
  EXPECT_EQ(load_of("indentation = 0.1\ntangential = [0, 0.1, 0.05]").tangential, (std::vector{0.0, 0.1, 0.05}));
  EXPECT_TRUE(fem::load_path(load_of("indentation = 0.1\ntangential_step = 0.1")).until_sliding);
}

TEST(SceneFile, ProfileFromBesideTheScene) {
  const ScratchFolder folder;
  folder.write("tip.csv", "\xEF\xBB\xBF# scanned\r\n x , y \r\n\r\n-1.0, 0.2\r\n0,0\r\n# a remark\r\n1e0,2e-1");
  const std::string text =
      "[indenter]\nshape = \"profile\"\nfile = \"tip.csv\"\nsmooth = 0.01\n[load]\nindentation = 0.1\n";
  const auto profile = std::get<fem::Profile>(read_scene(folder.write("scene.toml", text)).indenter.shape);
  EXPECT_EQ(profile.x, (std::vector{-1.0, 0.0, 1.0}));
  EXPECT_EQ(profile.y, (std::vector{0.2, 0.0, 0.2}));
  EXPECT_EQ(profile.smooth, 0.01);
}

TEST(SceneFile, PaperPreset) {
  const fem::Scene scene = read_text("preset = \"paper\"\n");
  const fem::Sensor expected{
      .poisson = 0.49, .grading = 2.75, .element = fem::Element::q4i, .stress = fem::StressRecovery::element};
  EXPECT_EQ(scene.sensor, expected);
  EXPECT_EQ(std::get<fem::Parabola>(scene.indenter.shape).radius, 97.0);
  EXPECT_EQ(scene.friction, 0.4);
  const fem::LoadPath path = fem::load_path(scene.load);
  EXPECT_EQ(path.indentation_steps, 10);
  ASSERT_EQ(path.steps.size(), 14u);
  EXPECT_EQ(path.steps[9].normal, 0.15);
  EXPECT_DOUBLE_EQ(path.steps.back().tangential, 0.3);
}

TEST(SceneFile, PaperPresetGivesWayToTheFile) {
  const fem::Scene scene = read_text(R"(preset = "paper"
[sensor]
columns = 123
rows = 33
[contact]
friction = 0.9
[load]
tangential_steps = 2
)");
  EXPECT_EQ(scene.sensor.columns, 123);
  EXPECT_EQ(scene.sensor.poisson, 0.49);
  EXPECT_EQ(scene.friction, 0.9);
  EXPECT_EQ(fem::load_path(scene.load).steps.size(), 12u);
}

TEST(SceneFile, PaperPresetWithAnotherShapeAndLoad) {
  const fem::Scene scene = read_text(R"(preset = "paper"
[indenter]
shape = "wedge"
edge_angle = 150
[load]
normal_force = 2.0
angle = 5
)");
  EXPECT_EQ(std::get<fem::Wedge>(scene.indenter.shape).edge_angle, 150.0);
  EXPECT_TRUE(scene.load.indentation.empty());
  EXPECT_EQ(scene.load.tangential_step, 0.0);
  EXPECT_EQ(fem::load_path(scene.load).steps.size(), 10u);
}

TEST(SceneJson, DefaultsFilledIn) {
  const fem::Scene scene =
      read_text("title = \"t\"\n[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.15\n");
  const auto expected = nlohmann::ordered_json::parse(R"({
    "title": "t",
    "sensor": {"model": "patch", "length": 20.0, "thickness": 1.5, "young": 2.0, "poisson": 0.45, "columns": 41, "rows": 11,
               "grading": 4.0, "element": "bbar", "tactels": 21, "tactel_span": 20.0, "tactel_width": 0.0,
               "stress": "reaction"},
    "indenter": {"shape": "parabola", "radius": 10.0, "position": 0.0},
    "contact": {"friction": 0.5},
    "load": {"indentation": 0.15, "indentation_steps": 1}})");
  EXPECT_EQ(to_json(scene), expected);
}

TEST(SceneFile, ModelIsTheMeshWhereTheFileNamesOne) {
  const auto model_of = [](const std::string& sensor) {
    return read_text("[sensor]\n" + sensor +
                     "[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.1\n")
        .model;
  };
  EXPECT_EQ(model_of("model = \"patch\"\n"), fem::SurfaceModel::patch);
  EXPECT_EQ(model_of("model = \"mesh\"\n"), fem::SurfaceModel::mesh);
  EXPECT_EQ(model_of("model = \"auto\"\nrows = 6\n"), fem::SurfaceModel::mesh);
  for (const char* key :
       {"columns = 41\n", "rows = 6\n", "grading = 2\n", "element = \"q4\"\n", "stress = \"element\"\n"})
    EXPECT_THROW(model_of(std::string("model = \"patch\"\n") + key), ConfigError) << key;
}

TEST(SceneJson, EveryKindOfLoad) {
  const auto json_of = [](const std::string& lines) {
    const fem::Scene scene{.load = load_of(lines)};
    return to_json(scene)["load"].dump();
  };
  EXPECT_EQ(json_of("indentation = [0.1, 0.05]\ntangential = [0.1, 0.0]"),
            R"({"indentation":[0.1,0.05],"indentation_steps":1,"tangential":[0.1,0.0]})");
  EXPECT_EQ(json_of("normal_force = 1\nangle = 10"), R"({"normal_force":1.0,"indentation_steps":1,"angle":10.0})");
  EXPECT_EQ(json_of("indentation = 0.1\ntangential_step = 0.05\ntangential_steps = 8"),
            R"({"indentation":0.1,"indentation_steps":1,"tangential_step":0.05,"tangential_steps":8})");
}

}  // namespace tactel::host::scene_file_test
