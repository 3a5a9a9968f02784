// SPDX-License-Identifier: Apache-2.0

// Contacts of a sweep file of pads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "fem/pad/pad_markers.h"
#include "host/scenes/scene_source.h"
#include "host/support/errors.h"
#include "tests/host/scenes/sweep_text.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::pad_source_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::Ge;
using testing::HasSubstr;
using testing::Le;

const std::string head = "[sweep]\ncontacts = 500\nseed = 7\n";
const std::string sensor = "[sensor]\nkind = \"pad\"\nthickness = 2\n";
const std::string sphere = "[indenter]\nshape = \"sphere\"\nradius = 5\n";
const std::string press = "[load]\nindentation = 0.2\n";

TEST(PadSource, SidesAreHeldUnlessAskedFor) {
  const std::string outline = sensor + "length = 20\nwidth = 20\n";
  EXPECT_EQ(pads(head + outline + sphere + press).contact(0).scene.sensor.sides, fem::Sides::held);
  EXPECT_EQ(pads(head + outline + "sides = \"free\"\n" + sphere + press).contact(0).scene.sensor.sides,
            fem::Sides::free);
  const std::string drawn =
      "[sensor]\nkind = \"pad\"\nthickness = { uniform = [2, 3] }\nlength = 20\nwidth = 20\nsides = \"free\"\n";
  EXPECT_THAT(message_of<PadSource>(head + drawn + sphere + press),
              HasSubstr("sensor.sides = \"free\": must be \"held\" where each contact draws"));
  EXPECT_EQ(pads("[sweep]\ncontacts = 500\nsensors = 3\n" + drawn + sphere + press).contact(0).scene.sensor.sides,
            fem::Sides::free);
}

TEST(PadSource, DrawsEveryNumberFromItsRange) {
  const PadSource sweep = pads(
      head +
      "[[sensor]]\nkind = \"pad\"\nthickness = { uniform = [1, 2] }\nyoung = { log_uniform = [0.5, 4] }\n"
      "poisson = { choice = [0.4, 0.5] }\n"
      "[contact]\nfriction = { uniform = [0.1, 1] }\n"
      "[[indenter]]\nshape = \"box\"\nhalf_widths = [{ uniform = [1, 2] }, { uniform = [3, 4] }]\n"
      "edge = { uniform = [0.1, 0.2] }\nposition = [{ uniform = [-1, 0] }, { uniform = [2, 3] }]\n"
      "yaw = { uniform = [10, 20] }\ntilt = { uniform = [1, 2] }\ntilt_direction = { uniform = [30, 40] }\nweight = 3\n"
      "[[indenter]]\nshape = \"paraboloid\"\nradii = [5, { uniform = [6, 7] }]\n"
      "[load]\nindentation = { uniform = [0.05, 0.1] }\n"
      "tangential = [[{ uniform = [0, 1] }, 2], [3, { uniform = [4, 5] }]]\ntwist = [{ uniform = [5, 6] }, 7]\n");
  EXPECT_EQ(sweep.inputs(), 48);
  EXPECT_THAT(sweep.kind_names(), ElementsAre("box", "paraboloid"));
  ASSERT_TRUE(sweep.own_sensors());
  int boxes = 0;
  std::set<double> poissons;
  for (std::uint64_t k = 0; k < 500; ++k) {
    const auto [scene, kind] = sweep.contact(k);
    const auto in = [](double value, double low, double high) { EXPECT_THAT(value, AllOf(Ge(low), Le(high))); };
    in(scene.sensor.thickness, 1, 2), in(scene.sensor.young, 0.5, 4), in(scene.friction, 0.1, 1);
    poissons.insert(scene.sensor.poisson);
    boxes += kind == 0;
    if (kind == 0) {
      const auto& box = std::get<fem::Box>(scene.indenter.shape);
      in(box.half_widths[0], 1, 2), in(box.half_widths[1], 3, 4), in(box.edge, 0.1, 0.2);
      in(scene.indenter.position[0], -1, 0), in(scene.indenter.position[1], 2, 3), in(scene.indenter.yaw, 10, 20);
      in(scene.indenter.tilt, 1, 2), in(scene.indenter.tilt_direction, 30, 40);
    } else {
      const auto& paraboloid = std::get<fem::Paraboloid>(scene.indenter.shape);
      EXPECT_EQ(paraboloid.radii[0], 5);
      in(paraboloid.radii[1], 6, 7);
    }
    in(scene.load.indentation[0], 0.05, 0.1);
    ASSERT_EQ(scene.load.drags.size(), 2u);
    const double degree = std::numbers::pi / 180;
    in(scene.load.drags[0][0], 0, 1), in(scene.load.drags[1][1], 4, 5), in(scene.load.drags[0][2] / degree, 5, 6);
    EXPECT_EQ(scene.load.drags[0][1], 2);
    EXPECT_EQ(scene.load.drags[1][0], 3);
    EXPECT_DOUBLE_EQ(scene.load.drags[1][2], 7 * degree);
  }
  EXPECT_NEAR(boxes, 375, 40);  // three of four; four deviations of sqrt(500 / 4 * 3 / 4)
  EXPECT_EQ(poissons, (std::set{0.4, 0.5}));
}

// A parameter that a shape has not is NaN.
TEST(PadSource, ParametersAreTheNumbersOfTheContacts) {
  const PadSource sweep = pads(head + "[sensor]\nkind = \"pad\"\nthickness = { uniform = [1, 2] }\n" + press +
                               "[[indenter]]\nshape = \"cone\"\nangle = { uniform = [60, 80] }\nposition = [1, 2]\n"
                               "[[indenter]]\nshape = \"punch\"\nradius = 3\nedge = 0.1\ntilt = 1\n");
  const auto parameters = sweep.parameters();
  std::vector<std::string> names;
  for (const auto& column : parameters.columns()) names.push_back(column.name + " " + column.unit);
  EXPECT_THAT(names, ElementsAre("indenter place in the attribute indenter_names", "indenter.position_x mm",
                                 "indenter.position_y mm", "indenter.yaw degrees", "indenter.tilt degrees",
                                 "indenter.tilt_direction degrees", "contact.friction 1", "indenter.angle degrees",
                                 "indenter.radius mm", "indenter.edge mm", "sensor.thickness mm", "sensor.young MPa",
                                 "sensor.poisson 1"));
  for (std::uint64_t k = 0; k < 20; ++k) {
    const auto [scene, kind] = sweep.contact(k);
    std::vector<float> row(names.size());
    parameters.put(scene, kind, row);
    const float none = std::nanf("");
    std::vector<float> expected = {1, 0, 0, 0, 1, 0, 0.5f, none, 3, 0.1f, 0, 2, 0.45f};
    if (kind == 0)
      expected = {0,    1,    2, 0, 0,    0, 0.5f, static_cast<float>(std::get<fem::Cone>(scene.indenter.shape).angle),
                  none, none, 0, 2, 0.45f};
    expected[10] = static_cast<float>(scene.sensor.thickness);
    EXPECT_THAT(row, testing::Pointwise(testing::NanSensitiveFloatEq(), expected));
  }
}

TEST(PadSource, DrawsSoftObjects) {
  const std::string soft = sphere + "young = { log_uniform = [0.1, 10] }\npoisson = { uniform = [0.3, 0.5] }\n";
  const PadSource sweep = pads(head + sensor + soft + press);
  const auto parameters = sweep.parameters();
  std::set<double> youngs;
  for (std::uint64_t k = 0; k < 50; ++k) {
    const auto [scene, kind] = sweep.contact(k);
    EXPECT_THAT(scene.indenter.young.value(), AllOf(Ge(0.1), Le(10)));
    EXPECT_THAT(scene.indenter.poisson, AllOf(Ge(0.3), Le(0.5)));
    youngs.insert(*scene.indenter.young);
    std::vector<float> row(parameters.columns().size());
    parameters.put(scene, kind, row);
    const auto number = [&](const std::string& name) {
      const auto column =
          std::ranges::find(parameters.columns(), name, &ContactParametersOf<fem::PadScene>::Column::name);
      return row.at(static_cast<std::size_t>(column - parameters.columns().begin()));
    };
    EXPECT_EQ(number("indenter.young"), static_cast<float>(*scene.indenter.young));
    EXPECT_EQ(number("indenter.poisson"), static_cast<float>(scene.indenter.poisson));
  }
  EXPECT_EQ(youngs.size(), 50u);
  EXPECT_THAT(message_of<PadSource>(head + sensor + sphere + "young = { uniform = [-1, 1] }\n" + press),
              HasSubstr("indenter.young"));
  EXPECT_THAT(message_of<PadSource>(head + sensor + sphere + "poisson = 0.3\n" + press),
              HasSubstr("given with indenter.young"));
  EXPECT_THAT(message_of<PadSource>(head + sensor + "curvature_radius = { uniform = [20, 30] }\n" + sphere + press),
              HasSubstr("sensor.curvature_radius"));
}

TEST(PadSource, SensorsMayHaveLayers) {
  const std::string layers =
                        "[[sensor.layers]]\nthickness = 1.8\nyoung = "
                        "1\n[[sensor.layers]]\nthickness = 0.2\n",
                    of_pads = "kind = \"pad\"\n";
  const PadSource one = pads(head + "[sensor]\n" + of_pads + layers + "young = 10\n" + sphere + press);
  EXPECT_EQ(one.contact(3).scene.sensor.layers, (std::vector<RubberLayer>{{1.8, 1, 0.45}, {0.2, 10, 0.45}}));
  EXPECT_EQ(one.contact(3).scene.sensor.thickness, 2);
  const PadSource two = pads(head + "[[sensor]]\n" + of_pads + layers + "young = 10\n[[sensor]]\n" + of_pads +
                             "thickness = 2\n" + sphere + press);
  std::set<std::size_t> counts;
  for (std::uint64_t k = 0; k < 50; ++k) counts.insert(two.contact(k).scene.sensor.layers.size());
  EXPECT_EQ(counts, (std::set<std::size_t>{0, 2}));
  EXPECT_THAT(message_of<PadSource>(head + "[sensor]\n" + of_pads + layers + "young = { uniform = [1, 10] }\n" +
                                    sphere + press),
              HasSubstr("sensor.layers[1].young"));
  EXPECT_THAT(message_of<PadSource>(head + "[sensor]\n" + of_pads + "poisson = { uniform = [0.3, 0.4] }\n" + layers +
                                    "young = 10\n" + sphere + press),
              HasSubstr("left out beside sensor.layers"));
}

TEST(PadSource, EqualStepsAreMultiplesOfOneNumber) {
  const PadSource sweep = pads(head + sensor + sphere +
                               "[load]\nindentation = 0.2\ntangential_step = [{ uniform = [0.01, 0.02] }, 0]\n"
                               "twist_step = { uniform = [1, 2] }\ntangential_steps = 3\n");
  const auto drags = sweep.contact(3).scene.load.drags;
  ASSERT_EQ(drags.size(), 3u);
  EXPECT_THAT(drags[0][0], AllOf(Ge(0.01), Le(0.02)));
  EXPECT_THAT(drags[0][2], AllOf(Ge(std::numbers::pi / 180), Le(std::numbers::pi / 90)));
  for (int k = 1; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) EXPECT_DOUBLE_EQ(drags[k][axis], (k + 1) * drags[0][axis]);
}

TEST(PadSource, SharedSensorsAreDrawnOnce) {
  const PadSource sweep = pads("[sweep]\ncontacts = 200\nsensors = 3\n[sensor]\nkind = \"pad\"\nthickness = 2\n" +
                               ("poisson = { uniform = [0.3, 0.5] }\n" + sphere) + press);
  std::set<double> poissons;
  for (std::uint64_t k = 0; k < 200; ++k) poissons.insert(sweep.contact(k).scene.sensor.poisson);
  EXPECT_EQ(poissons.size(), 3u);
}

TEST(PadSource, TactelsMayLieWithinTheRubber) {
  const PadSource sweep = pads(head + sensor + "depth = 0.5\nyoung = { uniform = [1, 2] }\n" + sphere + press);
  EXPECT_EQ(sweep.contact(3).scene.sensor.depth, 0.5);
  EXPECT_EQ(pads(head + sensor + sphere + press).contact(3).scene.sensor.depth, 0);
  EXPECT_THAT(message_of<PadSource>(head + "[sensor]\nkind = \"pad\"\ndepth = 0.5\nthickness = { uniform = [2, 3] }\n" +
                                    sphere + press),
              AllOf(HasSubstr("sensor.depth"), HasSubstr("its own thickness")));
  for (const char* depth : {"-0.1", "1.51", "nan", "'half'", "{ uniform = [0, 1] }"})
    EXPECT_THAT(message_of<PadSource>(head + sensor + "depth = " + depth + "\n" + sphere + press),
                HasSubstr("sensor.depth"))
        << depth;
  EXPECT_THAT(
      message_of<PadSource>(head + sensor + "depth = 0.5\nlength = 20\nwidth = 20\nsides = 'free'\n" + sphere + press),
      AllOf(HasSubstr("sensor.depth"), HasSubstr("where sides are free")));
}

TEST(PadSource, RubberThatCreepsHasTimes) {
  const std::string creeping = sensor + "relaxation = [[0.2, 0.5]]\n", timed = "times = [1.0]\n";
  const PadSource sweep = pads(head + creeping + sphere + press + timed);
  EXPECT_EQ(sweep.contact(3).scene.load.times, std::vector{1.0});
  const PadSource drawn = pads(head + creeping + sphere + press + "times = [{ uniform = [1, 2] }]\n");
  EXPECT_NE(drawn.contact(3).scene.load.times, drawn.contact(4).scene.load.times);
  EXPECT_THAT(message_of<PadSource>(head + creeping + sphere + press),
              AllOf(HasSubstr("sensor.relaxation"), HasSubstr("given with load.times")));
  EXPECT_THAT(message_of<PadSource>(head + sensor + sphere + press + timed), HasSubstr("load.times"));
  EXPECT_THAT(message_of<PadSource>(head + creeping + sphere + press + "times = [1.0, 2.0]\n"),
              HasSubstr("load.times"));
  EXPECT_THAT(message_of<PadSource>(head + creeping + sphere + press + "times = [-1.0]\n"), HasSubstr("load.times"));
  EXPECT_THAT(message_of<PadSource>(head + creeping + sphere +
                                    "[[load]]\nindentation = 0.1\ntimes = [1.0]\n"
                                    "[[load]]\nindentation = 0.1\n"),
              AllOf(HasSubstr("load.times"), HasSubstr("in every [[load]]")));
  EXPECT_THAT(message_of<PadSource>(head + creeping + sphere + press + timed + "[load.irregular]\nsteps = 20\n"),
              AllOf(HasSubstr("load.times"), HasSubstr("left out, because load.irregular is given too")));
}

TEST(PadSource, ContactsShareTheirMarkers) {
  const std::string markers = "[markers]\ncounts = [3, 2]\npitch = 0.5\ndepth = 0.1\n";
  const PadSource sweep = pads(head + sensor + "young = { uniform = [1, 2] }\n" + sphere + press + markers);
  EXPECT_EQ(sweep.markers(), (Markers{.counts = {3, 2}, .pitch = {0.5, 0.5}, .depth = 0.1}));
  EXPECT_EQ(sweep.contact(7).scene.markers, sweep.markers());
  EXPECT_FALSE(pads(head + sensor + sphere + press).markers());
  const auto refused = [&](const std::string& of_pad, const std::string& keys) {
    return message_of<PadSource>(head + of_pad + sphere + press + "[markers]\n" + keys);
  };
  EXPECT_THAT(refused("[sensor]\nkind = \"pad\"\nthickness = { uniform = [2, 3] }\n", ""),
              AllOf(HasSubstr("markers"), HasSubstr("its own thickness"), HasSubstr("[sweep] sensors = n")));
  const PadSource seen = pads(head + sensor + sphere + press + markers + "[camera]\nnoise_px = 0.1\n");
  EXPECT_EQ(seen.camera(), Camera{.noise_px = 0.1});
  EXPECT_EQ(seen.contact(7).scene.camera, seen.camera());
  EXPECT_FALSE(sweep.camera());
  for (const char* noise : {"-0.1", "nan", "inf", "1e7", "'much'", "{ uniform = [0, 1] }"})
    EXPECT_THAT(refused(sensor, std::string("[camera]\nnoise_px = ") + noise), HasSubstr("camera.noise_px")) << noise;
  EXPECT_THAT(message_of<PadSource>(head + sensor + sphere + press + "[camera]\n"), HasSubstr("without markers"));
  EXPECT_THAT(refused(sensor, "depth = 0.03\n"),
              HasSubstr("markers.depth = 0.03: must be a fiftieth of sensor.thickness or more in sweeps"));
  EXPECT_THAT(refused(sensor, "depth = { uniform = [0.1, 0.2] }\n"), HasSubstr("markers.depth"));
}

/// The numbers of a file of places are inputs of a set, as those of measured profiles.
TEST(PadSource, PlacesOfMarkersCount) {
  const ScratchFolder folder;
  const auto file = folder.write("sweep.toml", head + sensor + sphere + press + "[markers]\nplaces = \"dots.csv\"\n");
  const auto of = [&](const char* places) {
    folder.write("dots.csv", places);
    return PadSource::read(file);
  };
  const PadSource two = of("0.0,1\n0.5,2\n"), other = of("0.0,1\n0.5,2.1\n");
  EXPECT_EQ(fem::marker_count(two.markers()), 2u);
  ASSERT_EQ(two.files().size(), 1u);
  EXPECT_EQ(two.files()[0].first, "dots.csv");
  EXPECT_NE(two.files()[0].second, other.files()[0].second);
}

TEST(PadSource, ErrorsNameTheKey) {
  const auto with_load = [&](const std::string& load) { return message_of<PadSource>(head + sensor + sphere + load); };
  EXPECT_THAT(message_of<PadSource>(head + sensor + "poisson = { uniform = [0.3, 0.6] }\n" + sphere + press),
              HasSubstr("0 <= poisson <= 0.5"));
  EXPECT_THAT(message_of<PadSource>(head + "[[sensor]]\nkind = \"pad\"\nthickness = 2\n[[sensor]]\nthickness = 2\n" +
                                    sphere + press),
              HasSubstr("sensor.kind"));
  EXPECT_THAT(
      message_of<PadSource>(head +
                            "[[sensor]]\nkind = \"pad\"\nthickness = 2\n[[sensor]]\nkind = \"pad\"\nthickness = 2\n"
                            "axes = 1\n" +
                            sphere + press),
      HasSubstr("sensor.tactels"));
  EXPECT_THAT(message_of<PadSource>(head + sensor + "tactel_size = { uniform = [0, 1] }\n" + sphere + press),
              AllOf(HasSubstr("sensor.tactel_size"), HasSubstr("may be distributions")));
  EXPECT_THAT(message_of<PadSource>(head + sensor + sphere + "tilt = { uniform = [0, 1] }\n" + press),
              HasSubstr("indenter.tilt"));
  EXPECT_THAT(with_load("[load]\nindentation = { uniform = [-1, 1] }\n"), HasSubstr("load.indentation"));
  EXPECT_THAT(with_load("[load]\nnormal_force = 1\nslip_index = 0.5\n"), HasSubstr("load.slip_index"));
  EXPECT_THAT(with_load(press + "[load.irregular]\nbackward = 0.5\n"), HasSubstr("load.irregular.backward"));
  EXPECT_THAT(with_load(press + "twist = [1]\n[load.irregular]\n"), HasSubstr("load.twist"));
  EXPECT_THAT(with_load(press + "[load.irregular]\nstrokes = 5\ntwist = { uniform = [-90, 30] }\n"),
              AllOf(HasSubstr("load.irregular.twist"), HasSubstr("may have 450")));
  EXPECT_THAT(with_load(press + "[load.irregular]\ndirection = 400\n"), HasSubstr("load.irregular.direction"));
}

const std::string irregular =
    "[load]\nindentation = 0.2\n[load.irregular]\nstrokes = 2\nstroke = 0.1\nstroke_steps = 3\npress_steps = 2\n";

/// A press of two steps, a stroke along y with a twist of 3 degrees, and one against it.
TEST(PadIrregularLoad, FixedNumbersGiveThePathWorkedByHand) {
  const fem::PadLoad load =
      pads(head + sensor + sphere + irregular + "direction = 90\ntwist = 3\nreversal = 1\n").contact(5).scene.load;
  ASSERT_EQ(load.indentation.size(), 2u);
  EXPECT_EQ(load.indentation[1], 0.2);
  EXPECT_TRUE(load.drags.empty());
  ASSERT_EQ(load.moves.size(), 6u);
  for (const fem::PadTarget& move : load.moves) EXPECT_EQ(move.normal, 0.2);
  EXPECT_NEAR(load.moves[2].x, 0, 1e-15);
  EXPECT_NEAR(load.moves[2].y, 0.1, 1e-15);
  EXPECT_NEAR(load.moves[2].twist, 3 * std::numbers::pi / 180, 1e-15);
  EXPECT_NEAR(load.moves[0].twist / load.moves[2].twist, load.moves[0].y / load.moves[2].y, 1e-12);  // both at once
  EXPECT_NEAR(load.moves[5].y, 0, 1e-15);
  EXPECT_NEAR(load.moves[5].twist, 0, 1e-15);
}

/// Of 500 contacts: directions all around, a share of strokes reversed; four deviations.
TEST(PadIrregularLoad, StrokesHaveTheStatisticsAskedFor) {
  const PadSource sweep = pads(head + sensor + sphere + irregular +
                               "direction = { uniform = [0, 360] }\ntwist = { uniform = [-5, 5] }\nreversal = 0.25\n");
  int reversed = 0, left = 0, untwisted = 0;
  for (std::uint64_t k = 0; k < 500; ++k) {
    const auto moves = sweep.contact(k).scene.load.moves;
    ASSERT_EQ(moves.size(), 6u);
    const double x = moves[5].x - moves[2].x, y = moves[5].y - moves[2].y;
    EXPECT_NEAR(std::hypot(moves[2].x, moves[2].y), 0.1, 1e-12);
    EXPECT_NEAR(std::hypot(x, y), 0.1, 1e-12);
    const bool back = std::hypot(moves[5].x, moves[5].y) < 1e-9;
    reversed += back, left += moves[2].x < 0;
    if (back) {  // and twisted back
      EXPECT_LE((moves[5].twist - moves[2].twist) * moves[2].twist, 0);
    }
    untwisted += std::abs(moves[2].twist) < 2.5 * std::numbers::pi / 180;
  }
  EXPECT_NEAR(reversed, 125, 39);
  EXPECT_NEAR(left, 250, 45);
  EXPECT_NEAR(untwisted, 250, 45);
}

TEST(PadIrregularLoad, ReleasesBetweenPressesStayInPlace) {
  const fem::PadLoad load =
      pads(head + sensor + sphere + irregular + "presses = 2\npress_depth = 0.5\n").contact(1).scene.load;
  ASSERT_EQ(load.moves.size(), 6u + 2 + 2 + 6);
  EXPECT_EQ(load.moves[7].normal, 0);
  EXPECT_EQ(load.moves[7].x, load.moves[5].x);
  EXPECT_EQ(load.moves[9].normal, 0.1);
  EXPECT_EQ(largest_normal(load), 0.2);
}

}  // namespace tactel::host::pad_source_test
