// SPDX-License-Identifier: Apache-2.0

// Scene files of pads: every key, shape and load, height maps, and every way to be wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "host/scenes/profile_csv.h"
#include "host/scenes/scene_file.h"
#include "host/support/errors.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace tactel::host::pad_file_test {

using testing::AllOf;

using testing::HasSubstr;

constexpr double degree = std::numbers::pi / 180;

fem::PadScene read_text(const std::string& text) {
  const ScratchFolder folder;
  return std::get<fem::PadScene>(read_any_scene(folder.write("scene.toml", text)));
}

std::string pad_text(const std::string& indenter = "shape = \"sphere\"\nradius = 8",
                     const std::string& load = "indentation = 0.2", const std::string& sensor = "thickness = 2") {
  return "[sensor]\nkind = \"pad\"\n" + sensor + "\n[indenter]\n" + indenter + "\n[load]\n" + load + "\n";
}

fem::PadIndenter indenter_of(const std::string& lines) { return read_text(pad_text(lines)).indenter; }
fem::PadLoad load_of(const std::string& lines) {
  return read_text(pad_text("shape = \"cone\"\nangle = 80", lines)).load;
}

TEST(PadFile, EveryKey) {
  const fem::PadScene scene = read_text(R"(title = "all of it"
[sensor]
kind = "pad"
tactels = [4, 6]
pitch = [4.7, 5.0]
tactel_size = 1.5
axes = 1
thickness = 3.0
young = 0.7
poisson = 0.5
length = 24.0
width = 40.0
[indenter]
shape = "punch"
radius = 3.0
edge = 0.5
position = [1.0, -0.5]
yaw = 30.0
tilt = 2.0
tilt_direction = 90.0
young = 1.5
poisson = 0.3
[contact]
friction = 0.8
[load]
indentation = [0.1, 0.3]
indentation_steps = 2
tangential = [[0.1, 0.0], [0.2, 0.1]]
twist = [0.0, 5.0]
)");
  EXPECT_EQ(scene.title, "all of it");
  EXPECT_EQ(scene.sensor.tactels, (std::array{4, 6}));
  EXPECT_EQ(scene.sensor.pitch, (std::array{4.7, 5.0}));
  EXPECT_EQ(scene.sensor.tactel_size, 1.5);
  EXPECT_EQ(scene.sensor.axes, 1);
  EXPECT_EQ(scene.sensor.thickness, 3);
  EXPECT_EQ(scene.sensor.young, 0.7);
  EXPECT_EQ(scene.sensor.poisson, 0.5);
  EXPECT_EQ(scene.sensor.length, 24);
  EXPECT_EQ(scene.sensor.width, 40);
  const auto& punch = std::get<fem::Punch>(scene.indenter.shape);
  EXPECT_EQ(punch.radius, 3);
  EXPECT_EQ(punch.edge, 0.5);
  EXPECT_EQ(scene.indenter.position, (std::array{1.0, -0.5}));
  EXPECT_EQ(scene.indenter.yaw, 30);
  EXPECT_EQ(scene.indenter.tilt, 2);
  EXPECT_EQ(scene.indenter.tilt_direction, 90);
  EXPECT_EQ(scene.indenter.young, 1.5);
  EXPECT_EQ(scene.indenter.poisson, 0.3);
  EXPECT_EQ(scene.friction, 0.8);
  EXPECT_EQ(scene.load.indentation, (std::vector{0.1, 0.3}));
  EXPECT_EQ(scene.load.indentation_steps, 2);
  ASSERT_EQ(scene.load.drags.size(), 2u);
  EXPECT_EQ(scene.load.drags[1][1], 0.1);
  EXPECT_DOUBLE_EQ(scene.load.drags[1][2], 5 * degree);
}

TEST(PadFile, WhatIsLeftOutTakesItsDefault) {
  const fem::PadScene scene = read_text(pad_text());
  EXPECT_EQ(scene.sensor.tactels, (std::array{4, 4}));
  EXPECT_EQ(scene.sensor.pitch, (std::array{4.7, 4.7}));
  EXPECT_EQ(scene.sensor.axes, 3);
  EXPECT_FALSE(scene.sensor.length || scene.sensor.width || scene.sensor.curvature_radius || scene.indenter.young);
  EXPECT_EQ(
      read_text(pad_text("shape = \"cone\"\nangle = 80", "indentation = 0.1", "thickness = 2\ncurvature_radius = 15"))
          .sensor.curvature_radius,
      15);
  const fem::PadSensor layered = read_text(pad_text("shape = \"cone\"\nangle = 80", "indentation = 0.1",
                                                    "[[sensor.layers]]\nthickness = 3\nyoung = "
                                                    "1\n[[sensor.layers]]\nthickness = 0.5\nyoung = 10\n"
                                                    "poisson = 0.4"))
                                     .sensor;
  EXPECT_EQ(layered.layers, (std::vector<RubberLayer>{{3, 1, 0.45}, {0.5, 10, 0.4}}));
  EXPECT_EQ(std::tuple(layered.thickness, layered.young, layered.poisson), std::tuple(3.5, 10.0, 0.4));
  const fem::PadScene marked = read_text(
      pad_text("shape = \"cone\"\nangle = 80",
               "indentation = 0.1\n[markers]\ncounts = [3, 2]\npitch = 0.5\n[camera]\ndistance = 30", "thickness = 2"));
  EXPECT_EQ(marked.markers, (Markers{.counts = {3, 2}, .pitch = {0.5, 0.5}}));
  EXPECT_EQ(marked.camera, Camera{.distance = 30});
  EXPECT_FALSE(scene.markers || scene.camera);
  EXPECT_EQ(scene.friction, 0.5);
  EXPECT_EQ(scene.indenter.position, (std::array{0.0, 0.0}));
  EXPECT_TRUE(scene.load.drags.empty());
  EXPECT_EQ(read_text(pad_text("shape = \"punch\"\nradius = 2", "indentation = 0.1", "thickness = 1\npitch = 3"))
                .sensor.pitch,
            (std::array{3.0, 3.0}));
}

TEST(PadFile, ALineIsALine) {
  const ScratchFolder folder;
  const std::string rest = "[indenter]\nshape = \"flat\"\n[load]\nindentation = 0.1\n";
  for (const char* sensor : {"", "[sensor]\nkind = \"line\"\n"})
    EXPECT_TRUE(std::holds_alternative<fem::Scene>(read_any_scene(folder.write("scene.toml", sensor + rest))));
}

TEST(PadFile, EveryShape) {
  EXPECT_EQ(std::get<fem::Sphere>(indenter_of("shape = \"sphere\"\nradius = 3").shape).radius, 3);
  EXPECT_EQ(std::get<fem::Paraboloid>(indenter_of("shape = \"paraboloid\"\nradii = [3, 5]").shape).radii,
            (std::array{3.0, 5.0}));
  const auto cylinder =
      std::get<fem::LyingCylinder>(indenter_of("shape = \"cylinder\"\nradius = 3\nhalf_length = 6").shape);
  EXPECT_EQ(cylinder.radius, 3);
  EXPECT_EQ(cylinder.half_length, 6);
  EXPECT_EQ(std::get<fem::Punch>(indenter_of("shape = \"punch\"\nradius = 3").shape).edge, 0);
  const auto box = std::get<fem::Box>(indenter_of("shape = \"box\"\nhalf_widths = [1, 2]\nedge = 0.5").shape);
  EXPECT_EQ(box.half_widths, (std::array{1.0, 2.0}));
  EXPECT_EQ(box.edge, 0.5);
  EXPECT_EQ(std::get<fem::Cone>(indenter_of("shape = \"cone\"\nangle = 80").shape).angle, 80);
}

TEST(PadFile, LoadsMayBeSequences) {
  EXPECT_EQ(load_of("normal_force = [1, 2]").normal_force, (std::vector{1.0, 2.0}));
  EXPECT_TRUE(load_of("normal_force = 1").indentation.empty());
  const fem::PadLoad steps =
      load_of("indentation = 0.1\ntangential_step = [0.1, -0.2]\ntwist_step = 3\ntangential_steps = 4");
  ASSERT_EQ(steps.drags.size(), 4u);
  EXPECT_DOUBLE_EQ(steps.drags[2][0], 0.3);
  EXPECT_DOUBLE_EQ(steps.drags[2][1], -0.6);
  EXPECT_DOUBLE_EQ(steps.drags[2][2], 9 * degree);
  const fem::PadLoad twist = load_of("indentation = 0.1\ntwist = [2, 0]");
  ASSERT_EQ(twist.drags.size(), 2u);
  EXPECT_EQ(twist.drags[0][0], 0);
  EXPECT_DOUBLE_EQ(twist.drags[0][2], 2 * degree);
  EXPECT_EQ(load_of("indentation = 0.1\ntwist_step = 1\ntangential_steps = 3").drags.size(), 3u);
}

// Rows of the file are y, columns x: the height at the middle of a cell of the grid is the mean of its corners.
TEST(PadFile, HeightMapFromBesideTheScene) {
  const ScratchFolder folder;
  folder.write("tip.csv", "# scanned, mm\n5.0; 6,0; 9\n\n5,5; 8.0; 7.0\n");
  const std::string text = pad_text("shape = \"heightmap\"\nfile = \"tip.csv\"\npitch = 0.5");
  const auto scene = std::get<fem::PadScene>(read_any_scene(folder.write("scene.toml", text)));
  const auto& map = std::get<fem::HeightMap>(scene.indenter.shape);
  EXPECT_EQ(map.pitch, 0.5);
  EXPECT_EQ(map.heights, (Eigen::MatrixXd(3, 2) << 0, 0.5, 1, 3, 4, 2).finished());
  EXPECT_DOUBLE_EQ(fem::pad_height(scene.indenter, 0.5, -0.25), 4);
  EXPECT_DOUBLE_EQ(fem::pad_height(scene.indenter, -0.25, 0), (0 + 0.5 + 1 + 3) / 4);
}

struct WrongMap {
  const char *text, *says;
};

TEST(PadFile, HeightMapsThatAreNone) {
  const ScratchFolder folder;
  const std::string scene =
      folder.write("scene.toml", pad_text("shape = \"heightmap\"\nfile = \"tip.csv\"\npitch = 0.5"));
  const auto message = [&](const std::string& csv) {
    folder.write("tip.csv", csv);
    return thrown_message<ConfigError>([&] { read_any_scene(scene); });
  };
  for (const auto& [csv, says] :
       std::initializer_list<WrongMap>{{"", "lines = 0"},
                                       {"0,1,2\n", "lines = 1"},
                                       {"0\n1\n", "tip.csv:1: heights = 1: must be 2 to 1000 lines"},
                                       {"0,1\n0,1,2\n", "tip.csv:2: fields = 3: must be 2"},
                                       {"0,1\n0,nan\n", "tip.csv:2: column 2 = nan"},
                                       {"0,1\n0,1e7\n", "tip.csv:2: column 2 = 1e7"},
                                       {"0,1\n0,\n", "tip.csv:2: column 2: must be"},
                                       {"0.0,1,2,3\n0,1,2,-9999\n", "indenter.file = 10002 mm of heights over 1.5 mm"},
                                       {"0,1,2,3\n0,1,2,3\n0,1,2,3\n", "this numbers the columns"},
                                       {"secret,1\n0,1\n", "tip.csv:1: column 1 = (not shown)"}})
    EXPECT_THAT(message(csv), HasSubstr(says)) << csv;
  std::string wide = "0", tall;
  for (std::size_t k = 0; k < longest_height_map; ++k) wide += ",0", tall += "0,0\n";
  EXPECT_THAT(message(wide + "\n" + wide + "\n"), HasSubstr("2 to 1000 heights"));
  EXPECT_THAT(message(tall + "0,0\n"), HasSubstr("2 to 1000 lines"));
  std::filesystem::remove(folder / "tip.csv");
  EXPECT_THAT(thrown_message<ConfigError>([&] { read_any_scene(scene); }), HasSubstr("a readable CSV file"));
}

// Rows of numbers, or a file of them: y increases from row to row.
TEST(PadFile, MapsOfFriction) {
  const FrictionMap map{{{0.6, 0.15, 0.2}, {0.5, 0.4, 0.3}}, 0.5};
  const std::string contact = pad_text() + "[contact]\nfriction_pitch = 0.5\nfriction_map = ";
  const fem::PadScene scene = read_text(contact + "[[0.6, 0.15, 0.2], [0.5, 0.4, 0.3]]\n");
  EXPECT_EQ(scene.friction_map, map);
  EXPECT_EQ(scene.friction, 0.6);
  EXPECT_EQ(read_text(pad_text()).friction_map, std::nullopt);
  const ScratchFolder folder;
  const std::string file = folder.write("scene.toml", contact + "\"wet.csv\"\n");
  const auto read = [&](const std::string& csv) {
    folder.write("wet.csv", csv);
    return std::get<fem::PadScene>(read_any_scene(file));
  };
  EXPECT_EQ(read("# rubbed, y by y\n0.6; 0,15; 0.2\n0.5; 0.4; 0.3\n").friction_map, map);
  EXPECT_THAT(thrown_message<ConfigError>([&] { read("0.5,0.6\n0.5\n"); }),
              HasSubstr("wet.csv:2: fields = 1: must be 2"));
  EXPECT_THAT(thrown_message<ConfigError>([&] { read("0.5\n-0.5\n"); }),
              HasSubstr("scene.toml:11: contact.friction_map = -0.5: must be coefficients of friction, 0 to 100"));
  EXPECT_THAT(thrown_message<ConfigError>([&] { read(""); }),
              HasSubstr("contact.friction_map = 0: must be 1 to 64 rows"));
  std::filesystem::remove(folder / "wet.csv");
  EXPECT_THAT(thrown_message<ConfigError>([&] { read_any_scene(file); }), HasSubstr("a readable CSV file"));
  for (const auto& [lines, says] :
       {std::pair{"friction_pitch = 1", "contact.friction_map = 0: must be 1 to 64 rows"},
        {"friction_pitch = 1\nfriction_map = [[0.5]]\nfriction = 0.5", "only one of friction, friction_map can be"},
        {"friction_pitch = 1\nfriction_map = 0.5", ":11: contact.friction_map = 0.5: must be the name of a CSV file"},
        {"friction_pitch = 1\nfriction_map = [0.5]", ":11: contact.friction_map = 0.5: must be the name of a CSV file"},
        {"friction_pitch = 1\nfriction_map = [[0.5, \"wet\"]]",
         ":11: contact.friction_map = \"wet\": must be the name"},
        {"friction_pitch = 1\nfriction_map = [[0.5, nan]]", ":11: contact.friction_map = nan: must be finite"},
        {"friction_pitch = 1\nfriction_map = [[0.5, 0.2], [0.5]]", "contact.friction_map = 1: must be 1 to 64 rows"},
        {"friction_pitch = 0\nfriction_map = [[0.5]]", ":10: contact.friction_pitch = 0: must be a length in mm"}})
    EXPECT_THAT(thrown_message<ConfigError>([&] { read_text(pad_text() + "[contact]\n" + lines + "\n"); }),
                HasSubstr(says))
        << lines;
}

struct WrongPad {
  std::string sensor, indenter, load;  ///< lines in place of the good ones, where not empty
  std::string says;                    ///< after the file's name
};

TEST(PadFile, PlacesOfMarkersMayStandInAFile) {
  const ScratchFolder folder;
  std::ofstream(folder / "scene.toml") << pad_text(
      "shape = \"cone\"\nangle = 80", "indentation = 0.1\n[markers]\nplaces = \"dots.csv\"", "thickness = 2");
  const auto read = [&](const std::string& csv) {
    std::ofstream(folder / "dots.csv") << csv;
    return std::get<fem::PadScene>(read_any_scene(folder / "scene.toml")).markers->places;
  };
  EXPECT_EQ(read("x,y\n0,1.5\n-2,0.25\n"), (std::vector<std::array<double, 2>>{{0, 1.5}, {-2, 0.25}}));
  EXPECT_THAT(thrown_message<ConfigError>([&] { read("0.5,1\n0.5,a\n"); }), HasSubstr("dots.csv:2: y = "));
  EXPECT_THAT(thrown_message<ConfigError>([&] { read("x,y\n"); }), HasSubstr("dots.csv: places = 0"));
  std::filesystem::remove(folder / "dots.csv");
  EXPECT_THAT(thrown_message<ConfigError>([&] { read_any_scene(folder / "scene.toml"); }),
              HasSubstr("a readable CSV file"));
}

TEST(PadFile, SaysWhatIsWrong) {
  const std::string line = "it belongs to a line, and sensor.kind is \"pad\"";
  const WrongPad wrong[] = {
      {"young = 1", "", "", ": sensor.thickness = (missing)"},
      {"thickness = 2\ntactels = [0, 1000000000]", "", "", ":4: sensor.tactels = 0: must be numbers"},
      {"thickness = 2\ntactels = 4", "", "", ":4: sensor.tactels = 4: must be two whole numbers"},
      {"thickness = 2\npitch = [1, 2, 3]", "", "", ":4: sensor.pitch = [1, 2, 3]"},
      {"thickness = 2\ntactel_size = 5", "", "", ":4: sensor.tactel_size = 5"},
      {"thickness = 2\naxes = 2", "", "", ":4: sensor.axes = 2: must be 3, or 1"},
      {"thickness = nan", "", "", ":3: sensor.thickness = nan: must be finite"},
      {"thickness = 2\nyoung = 1e308", "", "", ":4: sensor.young = 1e308"},
      {"thickness = 2\npoisson = 0.51", "", "", ":4: sensor.poisson = 0.51"},
      {"thickness = 2\nlength = 14", "", "",
       ":4: sensor.length = 14: must be a length in mm that holds the tactels, 14.1"},
      {"thickness = 2\nlength = 20\nsides = \"free\"", "", "",
       ":5: sensor.sides = \"free\": must be \"held\", or given with sensor.length and sensor.width"},
      {"thickness = 2\nsides = \"glued\"", "", "", ":4: sensor.sides = \"glued\": must be one of free, held"},
      {"thicknes = 2", "", "", "did you mean thickness?"},
      {"thickness = 2\ncolumns = 41", "", "", ":4: sensor.columns = 41: must be left out: " + line},
      {"thickness = 2\nmodel = \"patch\"", "", "", ":4: sensor.model = \"patch\": must be left out: " + line},
      {"", "radius = 8", "", ": indenter.shape = (missing)"},
      {"", "shape = \"sphere\"", "", ": indenter.radius = (missing)"},
      {"", "shape = \"parabola\"\nradius = 8", "", ":5: indenter.shape = \"parabola\": must be another one: " + line},
      {"", "shape = \"sphere\"\nradius = 8\nslope = 1", "", ":7: indenter.slope = 1: must be left out: " + line},
      {"", "shape = \"sphere\"\nradius = 8\nedge = 1", "",
       ":7: indenter.edge = 1: must be left out: it belongs to shape punch, box"},
      {"", "shape = \"sphere\"\nradius = 8\nposition = 1", "", ":7: indenter.position = 1: must be two numbers"},
      {"", "shape = \"cylinder\"\nradius = 8", "", ": indenter.half_length = (missing)"},
      {"", "shape = \"box\"\nhalf_widths = [1, nan]", "", ":6: indenter.half_widths = nan"},
      {"", "shape = \"box\"\nhalf_widths = [1, -1]", "", ":6: indenter.half_widths = -1"},
      {"", "shape = \"cone\"\nangle = 90", "", ":6: indenter.angle = 90"},
      {"", "shape = \"sphere\"\nradius = 1e308", "", ":6: indenter.radius = 1e308"},
      {"", "shape = \"punch\"\nradius = 2\ntilt = 60", "", ":7: indenter.tilt = 60"},
      {"", "shape = \"sphere\"\nradius = 8\nyoung = nan", "", ":7: indenter.young = nan: must be finite"},
      {"", "shape = \"sphere\"\nradius = 8\nyoung = -1", "", ":7: indenter.young = -1: must be a Young's modulus"},
      {"", "shape = \"sphere\"\nradius = 8\nyoung = 0", "", ":7: indenter.young = 0: must be a Young's modulus"},
      {"", "shape = \"sphere\"\nradius = 8\nyoung = 1\npoisson = 0.6", "",
       ":8: indenter.poisson = 0.6: must be a Poisson's"},
      {"", "shape = \"sphere\"\nradius = 8\npoisson = 0.3", "",
       ":7: indenter.poisson = 0.3: must be left out, or given with"},
      {"thickness = 2\ncurvature_radius = 9", "", "", ":4: sensor.curvature_radius = 9: must be 5 thicknesses or more"},
      {"thickness = 2\ncurvature_radius = -10", "", "", ":4: sensor.curvature_radius = -10"},
      {"thickness = 2\ncurvature_radius = nan", "", "", ":4: sensor.curvature_radius = nan: must be finite"},
      {"thickness = 2\ncurvature_radius = 20\nlength = 20\nwidth = 20", "", "",
       ":4: sensor.curvature_radius = 20: must be left out where sides are free; or sensor.sides = \"held\""},
      {"thickness = 2\n[[sensor.layers]]\nthickness = 1\nyoung = 1", "", "",
       ":3: sensor.thickness = 2: must be left out beside sensor.layers"},
      {"[[sensor.layers]]\nthickness = 1", "", "", ": sensor.layers[0].young = (missing)"},
      {"[[sensor.layers]]\nthickness = 1\nyoung = 1\ndepth = 1", "", "", ":6: sensor.layers[0].depth = 1"},
      {"[[sensor.layers]]\nthickness = 1\nyoung = 1\npoisson = 0.6", "", "",
       ":6: sensor.layers[0].poisson = 0.6: must be a Poisson's ratio"},
      {"layers = 3", "", "", ":3: sensor.layers = 3: must be tables [[sensor.layers]]"},
      {"layers = []", "", "", ":3: sensor.layers = []: must be tables [[sensor.layers]]"},
      {"length = 20\nwidth = 20\n[[sensor.layers]]\nthickness = 1\nyoung = 1", "", "",
       "must be left out where sides are free"},
      {"", "", "indentation = 1\n[markers]\ncounts = 3", ":10: markers.counts = 3"},
      {"", "", "indentation = 1\n[markers]\nplaces = []", ":10: markers.places = []: must be the name of a CSV file"},
      {"", "", "indentation = 1\n[markers]\nplaces = [[0, 1]]\npitch = 1", "markers.p"},
      {"", "", "indentation = 1\n[markers]\ndepth = 7", "markers.depth = 7: must be mm below the surface"},
      {"", "", "indentation = 1\n[markers]\nwide = 7", ":10: markers.wide"},
      {"", "", "indentation = 1\n[camera]\ndistance = 20", "camera = without markers: must be given with [markers]"},
      {"", "", "tangential_steps = 3", ": load.indentation = (missing)"},
      {"", "", "indentation = []", ":8: load.indentation = []"},
      {"", "", "indentation = -1", ":8: load.indentation = -1"},
      {"", "", "indentation = 1\nnormal_force = 1", ":9: load.normal_force = 1: must be left out"},
      {"", "", "indentation = 1\nindentation_steps = 100000000", ":9: load.indentation_steps = 100000000"},
      {"", "", "indentation = [1, 2]\nindentation_steps = 501", ":9: load.indentation_steps = 501: must be so few"},
      {"", "", "indentation = 1\nangle = 5", ":9: load.angle = 5: must be left out: " + line},
      {"", "", "indentation = 1\ntangential = []", ":9: load.tangential = []"},
      {"", "", "indentation = 1\ntangential = [0.1]", ":9: load.tangential = 0.1: must be an array of positions"},
      {"", "", "indentation = 1\ntangential = [[1, 2, 3]]", ":9: load.tangential = [1, 2, 3]"},
      {"", "", "indentation = 1\ntangential = [[1, 2e6]]", "load.tangential = 2000000: must be a place"},
      {"", "", "indentation = 1\ntangential = [[1, 2]]\ntwist = [1, 2]", ":10: load.twist = [1, 2]: must be as many"},
      {"", "", "indentation = 1\ntwist = [361]", ":9: load.twist = 361: must be degrees"},
      {"", "", "indentation = 1\ntwist = [1]\ntangential_step = [1, 1]", "only one of twist, tangential_step can be"},
      {"", "", "indentation = 1\ntangential_step = [1, 1]", ": load.tangential_steps = (missing)"},
      {"", "", "indentation = 1\ntangential_steps = 5", ":9: load.tangential_steps = 5: must be left out"},
      {"", "", "indentation = 1\ntwist_step = 1\ntangential_steps = 1000000000",
       ":10: load.tangential_steps = 1000000000"},
      {"", "", "indentation = 1\ndrag = 5", ":9: load.drag = 5: must be a known key"},
  };
  const ScratchFolder folder;
  for (const WrongPad& w : wrong) {
    const std::string text =
        pad_text(w.indenter.empty() ? "shape = \"sphere\"\nradius = 8" : w.indenter,
                 w.load.empty() ? "indentation = 0.2" : w.load, w.sensor.empty() ? "thickness = 2" : w.sensor);
    const std::string scene = folder.write("scene.toml", text);
    EXPECT_THAT(thrown_message<ConfigError>([&] { read_any_scene(scene); }),
                AllOf(HasSubstr("scene.toml"), HasSubstr(w.says)))
        << text;
  }
  for (const auto& [head, says] : {std::pair{"preset = \"paper\"\n", line.c_str()},
                                   {"[sweep]\ncontacts = 5\n", "`tactel generate` takes sweeps"}}) {
    const std::string scene = folder.write("scene.toml", head + pad_text());
    EXPECT_THAT(thrown_message<ConfigError>([&] { read_any_scene(scene); }), HasSubstr(says));
  }
  const std::string bonded = folder.write("scene.toml", pad_text() + "[contact]\nfriction = \"bonded\"\n");
  EXPECT_THAT(thrown_message<ConfigError>([&] { read_any_scene(bonded); }), HasSubstr("of a line alone"));
}

TEST(PadFile, KeysOfAPadInALine) {
  const ScratchFolder folder;
  const auto message = [&](const std::string& sensor, const std::string& indenter, const std::string& load) {
    const std::string scene = folder.write("scene.toml", "[sensor]\n" + sensor + "\n[indenter]\n" + indenter +
                                                             "\n[load]\nindentation = 0.1\n" + load + "\n");
    return thrown_message<ConfigError>([&] { read_scene(scene); });
  };
  const auto of_a_pad = HasSubstr("it belongs to a pad (sensor.kind = \"pad\")");
  EXPECT_THAT(message("pitch = 4", "shape = \"flat\"", ""), AllOf(HasSubstr(":2: sensor.pitch = 4"), of_a_pad));
  EXPECT_THAT(message("", "shape = \"sphere\"\nradius = 4", ""),
              AllOf(HasSubstr("indenter.shape = \"sphere\""), of_a_pad));
  EXPECT_THAT(message("", "shape = \"flat\"\nyaw = 4", ""), AllOf(HasSubstr("indenter.yaw = 4"), of_a_pad));
  EXPECT_THAT(message("", "shape = \"flat\"\nyoung = 4", ""), AllOf(HasSubstr("indenter.young = 4"), of_a_pad));
  EXPECT_THAT(message("", "shape = \"flat\"", "twist = [4]"), AllOf(HasSubstr("load.twist = [4]"), of_a_pad));
  EXPECT_THAT(message("kind = \"pad\"", "shape = \"flat\"", ""),
              HasSubstr(":2: sensor.kind = \"pad\": must be \"line\" here: scenes of pads are for solve, simulate:"));
  EXPECT_THAT(message("kind = \"square\"", "shape = \"flat\"", ""), HasSubstr("one of line, pad"));
}

}  // namespace tactel::host::pad_file_test
