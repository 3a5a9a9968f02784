// SPDX-License-Identifier: Apache-2.0

// Contacts of a sweep file.
#include "host/scenes/scene_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "host/support/errors.h"
#include "tests/host/scenes/sweep_text.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::scene_source_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string head = "[sweep]\ncontacts = 2000\nseed = 7\n";
const std::string load = "[load]\nindentation = 0.15\ntangential_step = 0.05\ntangential_steps = 4\n";
const std::string parabola = "[indenter]\nshape = \"parabola\"\nradius = 10\n";

TEST(SceneSource, PlainNumbersStayAsTheyAre) {
  const SceneSource plain = source(head + load + parabola + "[contact]\nfriction = 0.7\n");
  EXPECT_EQ(plain.contacts(), 2000u);
  EXPECT_EQ(plain.seed(), 7u);
  const auto contact = plain.contact(1234);
  EXPECT_EQ(std::get<fem::Parabola>(contact.scene.indenter.shape).radius, 10);
  EXPECT_EQ(contact.scene.friction, 0.7);
  EXPECT_EQ(contact.scene.load.indentation, std::vector{0.15});
}

TEST(SceneSource, SensorsMayHaveLayers) {
  const std::string layers =
      "[[sensor.layers]]\nthickness = 1.2\nyoung = 1\n[[sensor.layers]]\nthickness = 0.3\nyoung = ";
  const SceneSource two = source(head + "[[sensor]]\n" + layers + "10\n[[sensor]]\n" + load + parabola);
  std::set<std::size_t> counts;
  for (std::uint64_t k = 0; k < 50; ++k) counts.insert(two.contact(k).scene.sensor.layers.size());
  EXPECT_EQ(counts, (std::set<std::size_t>{0, 2}));
  EXPECT_THAT(message_of(head + "[sensor]\n" + layers + "{ uniform = [1, 10] }\n" + load + parabola),
              HasSubstr("sensor.layers[1].young"));
  const std::string drawn = "[sensor]\nlength = { uniform = [15, 20] }\n" + layers + "10\n" + load + parabola;
  EXPECT_THAT(message_of(head + drawn), HasSubstr("sensor.layers"));
  EXPECT_THAT(message_of(head + drawn), HasSubstr("left out where each contact draws its own sensor"));
  EXPECT_EQ(source(head + "sensors = 3\n" + drawn).contact(7).scene.sensor.layers.size(), 2u);
}

// Beyond 32 bits both are what the file says, and each contact is drawn.
TEST(SceneSource, CountsContactsAndSeedsBeyond32Bits) {
  const auto with = [&](const char* contacts, const char* seed) {
    return "[sweep]\ncontacts = " + std::string(contacts) + "\nseed = " + seed + "\n" + load + parabola +
           "[contact]\nfriction = { uniform = [0, 1] }\n";
  };
  const SceneSource many = source(with("5000000000", "9223372036854775807"));
  EXPECT_EQ(many.contacts(), 5'000'000'000u);
  EXPECT_EQ(many.seed(), 9'223'372'036'854'775'807u);
  const double mu = many.contact(4'999'999'999).scene.friction;
  EXPECT_NE(mu, many.contact(4'999'999'999 - (std::uint64_t{1} << 32)).scene.friction);
  EXPECT_NE(mu, source(with("5000000000", "4294967295")).contact(4'999'999'999).scene.friction);  // its low 32 bits
  EXPECT_THAT(message_of(with("1099511627777", "1")), HasSubstr("1 to 1099511627776"));
}

// Expected: the scenes themselves. A number that a shape has not is NaN.
TEST(SceneSource, ParametersAreTheNumbersOfTheContacts) {
  const SceneSource sweep = source(
      head + load + "[[sensor]]\ncolumns = 11\nrows = 4\n[[sensor]]\ncolumns = 11\nrows = 4\nyoung = 3\n" +
      "[contact]\nfriction = { uniform = [0.1, 1.5] }\n"
      "[[indenter]]\nshape = \"parabola\"\nradius = { log_uniform = [1, 100] }\nposition = { uniform = [-2, 2] }\n"
      "[[indenter]]\nshape = \"taylor\"\npowers = [1, 3]\ncoefficients = [{ uniform = [0, 1] }, 0.5]\nscale = 4\n"
      "[[indenter]]\nshape = \"profile\"\npoints = 9\nhalf_width = { uniform = [3, 8] }\nheight = 0.5\n");
  const ContactParameters parameters = sweep.parameters();
  std::vector<std::string> names;
  for (const auto& column : parameters.columns()) names.push_back(column.name + " " + column.unit);
  EXPECT_THAT(
      names, ElementsAre("indenter place in the attribute indenter_names", "indenter.position mm", "contact.friction 1",
                         "indenter.radius mm", "indenter.scale mm", "indenter.height mm", "indenter.half_width mm",
                         "indenter.coefficient_1 1", "indenter.coefficient_3 1", "sensor.young MPa"));
  std::set<int> kinds;
  for (std::uint64_t k = 0; k < 20; ++k) {
    const auto contact = sweep.contact(k);
    const fem::Shape& shape = contact.scene.indenter.shape;
    std::vector<float> row(10);
    parameters.put(contact.scene, contact.kind, row);
    kinds.insert(contact.kind);
    std::vector<double> expected(10, std::nan(""));
    expected[0] = contact.kind, expected[1] = contact.scene.indenter.position, expected[2] = contact.scene.friction;
    expected[9] = contact.scene.sensor.young;
    if (contact.kind == 0) {
      expected[3] = std::get<fem::Parabola>(shape).radius;
    } else if (contact.kind == 1) {
      expected[4] = expected[5] = 4, expected[8] = 0.5;
      expected[7] = std::get<fem::Taylor>(shape).coefficients[0];
    } else {
      expected[6] = std::get<fem::Profile>(shape).x.back(), expected[5] = 0.5;
    }
    for (std::size_t i = 0; i < row.size(); ++i)
      EXPECT_TRUE(std::isnan(expected[i]) ? std::isnan(row[i]) : row[i] == static_cast<float>(expected[i]))
          << names[i] << ": " << row[i] << ", not " << expected[i];
  }
  EXPECT_EQ(kinds.size(), 3u);
}

// 21 tactels on 20 mm, or within a span; contacts whose sensors differ in it have none in common.
TEST(SceneSource, TactelsHaveTheirPlacesWhereContactsShareThem) {
  const auto with = [&](const std::string& sensor) { return source(head + load + parabola + sensor).tactel_x(); };
  const std::vector<float> x = with("");
  ASSERT_EQ(x.size(), 21u);
  EXPECT_EQ(x[0], -10);
  EXPECT_EQ(x[1], -9);
  EXPECT_EQ(x[20], 10);
  EXPECT_THAT(with("[sensor]\ntactels = 3\ntactel_span = 8\n"), ElementsAre(-4, 0, 4));
  EXPECT_THAT(with("[[sensor]]\n[[sensor]]\ntactel_span = 8\n"), IsEmpty());
  const std::string lengths = "[sensor]\nlength = { uniform = [18, 22] }\ntactels = 3\n";
  EXPECT_THAT(with(lengths), IsEmpty());
  EXPECT_THAT(with(lengths + "tactel_span = 8\n"), ElementsAre(-4, 0, 4));
}

const std::string mixed =
    head +
    "[contact]\nfriction = { uniform = [0.1, 1.5] }\n"
    "[[indenter]]\nshape = \"parabola\"\nradius = { log_uniform = [1, 100] }\nposition = { uniform = [-2, 2] }\n"
    "[[indenter]]\nshape = \"flat\"\nhalf_width = { uniform = [1, 3] }\nweight = 3\n"
    "[[load]]\nindentation = { uniform = [0.05, 0.2] }\ntangential = [{ uniform = [0.1, 0.2] }, -0.05]\n"
    "[[load]]\nnormal_force = { choice = [0.5, 1.0] }\nslip_index = { uniform = [0, 0.9] }\n";

// Quantiles 0.5 give the middle of each range: of log-uniform numbers the geometric mean, of normal ones the mean. Of
// two tables with weights 1 and 3 the second begins at 0.25.
TEST(SceneSource, QuantilesStandForDrawnNumbers) {
  const SceneSource sweep = source(mixed);
  const std::vector<bool> numbers = sweep.numbers();
  EXPECT_EQ(std::ranges::count(numbers, true), 7) << "friction, radius, position, half_width, depth, drag, slip index";
  std::vector<double> quantiles(2 * numbers.size(), 0.5);
  std::fill_n(quantiles.begin(), numbers.size(), 0.2);
  const SceneSource told = sweep.of_quantiles(quantiles);
  ASSERT_EQ(told.contacts(), 2u);
  EXPECT_FALSE(told.endless());
  const auto parabola = told.contact(0), flat = told.contact(1);
  EXPECT_EQ(parabola.kind, 0);
  EXPECT_EQ(flat.kind, 1);
  EXPECT_NEAR(parabola.scene.friction, 0.1 + 0.2 * 1.4, 1e-12);
  EXPECT_NEAR(std::get<fem::Parabola>(parabola.scene.indenter.shape).radius, std::pow(100, 0.2), 1e-9);
  EXPECT_NEAR(flat.scene.friction, 0.8, 1e-12);
  EXPECT_NEAR(std::get<fem::Flat>(flat.scene.indenter.shape).half_width.value(), 2, 1e-12);
}

// Mean 5 and deviation 2, cut at -2.495 deviations, where 0.00630 of them lie below, and at +4: a quarter of the rest
// ends at 0.25472 of all, -0.65972 deviations.
TEST(SceneSource, QuantilesOfNormalNumbers) {
  const SceneSource sweep =
      source(head + load + parabola + "[contact]\nfriction = { normal = [5, 2], min = 0.01, max = 13 }\n");
  const auto friction = [&](double quantile) {
    return sweep.of_quantiles(std::vector(sweep.numbers().size(), quantile)).contact(0).scene.friction;
  };
  EXPECT_NEAR(friction(0.25), 5 - 0.65972 * 2, 1e-4);
  EXPECT_NEAR(friction(0), 0.01, 1e-9);
  EXPECT_NEAR(friction(0.9999999), 13, 0.02);
}

// A path of quantiles is that of the same numbers: drawn shares between the bounds, counts as many as they say.
TEST(SceneSource, QuantilesOfAPath) {
  const SceneSource sweep = source(head + parabola +
                                   "[load]\nindentation = 0.1\n[load.irregular]\nstrokes = { choice = [1, 2] }\n"
                                   "stroke = { uniform = [0.1, 0.3] }\npress_steps = 2\nstroke_steps = 3\n");
  const auto scene = [&](double quantile) {
    return sweep.of_quantiles(std::vector(sweep.numbers().size(), quantile)).contact(0).scene;
  };
  ASSERT_EQ(scene(0.25).load.moves.size(), 3u);
  EXPECT_EQ(scene(0.75).load.moves.size(), 6u);
  EXPECT_NEAR(scene(0.25).load.moves.back().tangential, 0.1 + 0.25 * 0.2, 1e-12);
  EXPECT_NEAR(scene(0.25).load.indentation.front(), 0.05, 1e-12) << "two equal shares";
}

// 2000 draws: shares spread by at most 0.011, four of these.
TEST(SceneSource, DrawsAlternativesAndNumbers) {
  const SceneSource sweep = source(mixed);
  EXPECT_THAT(sweep.kind_names(), testing::ElementsAre("parabola", "flat"));
  int flats = 0, forced = 0;
  for (std::uint64_t k = 0; k < sweep.contacts(); ++k) {
    const auto contact = sweep.contact(k);
    const fem::Scene& scene = contact.scene;
    EXPECT_GE(scene.friction, 0.1);
    EXPECT_LE(scene.friction, 1.5);
    flats += contact.kind == 1;
    if (contact.kind == 1) {
      const double half_width = *std::get<fem::Flat>(scene.indenter.shape).half_width;
      EXPECT_THAT(half_width, testing::AllOf(testing::Ge(1), testing::Le(3)));
    }
    if (fem::by_force(scene)) {
      ++forced;
      const double s = std::tan(*scene.load.angle * 3.14159265358979 / 180) / scene.friction;
      EXPECT_THAT(s, testing::AllOf(testing::Ge(-1e-12), testing::Le(0.9)));
    } else {
      ASSERT_EQ(scene.load.tangential.size(), 2u);
      EXPECT_THAT(scene.load.tangential[0], testing::AllOf(testing::Ge(0.1), testing::Le(0.2)));
      EXPECT_EQ(scene.load.tangential[1], -0.05);
    }
  }
  EXPECT_NEAR(flats / 2000.0, 0.75, 0.044);
  EXPECT_NEAR(forced / 2000.0, 0.5, 0.044);
}

TEST(SceneSource, AContactDependsOnSeedAndNumberAlone) {
  std::string more = mixed, other = mixed;
  more.replace(more.find("2000"), 4, "9000");
  other.replace(other.find("seed = 7"), 8, "seed = 8");
  const SceneSource a = source(mixed), b = source(more), c = source(other);
  int same = 0;
  for (const std::uint64_t k : {1999u, 0u, 7u, 555u}) {
    EXPECT_EQ(a.contact(k).scene.friction, b.contact(k).scene.friction);
    EXPECT_EQ(a.contact(k).kind, b.contact(k).kind);
    same += a.contact(k).scene.friction == c.contact(k).scene.friction;
  }
  EXPECT_EQ(same, 0);
}

TEST(SceneSource, RandomProfilesAreConvexAndAsLargeAsAsked) {
  const SceneSource sweep = source(
      head + load + "[indenter]\nshape = \"profile\"\npoints = 9\nhalf_width = 4\nheight = { uniform = [0.5, 2] }\n");
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto profile = std::get<fem::Profile>(sweep.contact(k).scene.indenter.shape);
    ASSERT_EQ(profile.x.size(), 9u);
    EXPECT_EQ(profile.x.front(), -4);
    EXPECT_EQ(profile.x.back(), 4);
    const double highest = *std::max_element(profile.y.begin(), profile.y.end());
    EXPECT_THAT(highest, testing::AllOf(testing::Ge(0.5), testing::Le(2.0)));
    for (std::size_t i = 1; i + 1 < 9; ++i)  // second differences of equally spaced points, to rounding
      EXPECT_GE(profile.y[i - 1] - 2 * profile.y[i] + profile.y[i + 1], -1e-12);
  }
}

TEST(SceneSource, DistributedSensorsAreDrawnOnce) {
  const SceneSource sweep = source("[sweep]\ncontacts = 500\nsensors = 5\n" + load + parabola +
                                   "[sensor]\npoisson = { uniform = [0.3, 0.49] }\nthickness = { uniform = [1, 2] }\n");
  ASSERT_EQ(sweep.sensors().size(), 5u);
  std::set<double> seen;
  for (std::uint64_t k = 0; k < 500; ++k) seen.insert(sweep.contact(k).scene.sensor.poisson);
  EXPECT_EQ(seen.size(), 5u);
  for (const fem::Sensor& sensor : sweep.sensors()) EXPECT_TRUE(seen.contains(sensor.poisson));
}

const std::string own_sensor =
    "[sensor]\npoisson = { uniform = [0.3, 0.49] }\nthickness = { uniform = [1, 2] }\n"
    "young = { log_uniform = [1, 4] }\nlength = { choice = [18, 20] }\n";

TEST(SceneSource, EachContactOnAPatchDrawsItsOwnSensor) {
  const SceneSource sweep = source(head + load + parabola + own_sensor);
  ASSERT_TRUE(sweep.own_sensors());
  EXPECT_EQ(*sweep.own_sensors(),
            (fem::SensorRange{.poisson_low = 0.3, .poisson_high = 0.49, .longest = 20, .tactels = 21}));
  std::set<double> poisson, thickness, young, length;
  for (std::uint64_t k = 0; k < 500; ++k) {
    const fem::Sensor sensor = sweep.contact(k).scene.sensor;
    poisson.insert(sensor.poisson), thickness.insert(sensor.thickness);
    young.insert(sensor.young), length.insert(sensor.length);
    EXPECT_EQ(sensor, sweep.contact(k).scene.sensor);
    EXPECT_EQ(sensor.span(), sensor.length);
  }
  EXPECT_EQ(poisson.size(), 500u);
  EXPECT_EQ(thickness.size(), 500u);
  EXPECT_EQ(young.size(), 500u);
  EXPECT_EQ(length, (std::set<double>{18, 20}));
  EXPECT_GE(*poisson.begin(), 0.3);
  EXPECT_LE(*poisson.rbegin(), 0.49);
}

/// A sensor is a draw like the others: all else of a contact stays as it is without it.
TEST(SceneSource, OwnSensorsChangeNoOtherNumber) {
  const std::string rest = head + load + parabola + "[contact]\nfriction = { uniform = [0.1, 1] }\n";
  const SceneSource own = source(rest + own_sensor), few = source(rest + own_sensor + "\n");
  const std::string shared = "[sweep]\ncontacts = 2000\nseed = 7\nsensors = 3\n";
  const SceneSource three =
      source(shared + load + parabola + "[contact]\nfriction = { uniform = [0.1, 1] }\n" + own_sensor);
  EXPECT_FALSE(three.own_sensors());
  EXPECT_EQ(three.sensors().size(), 3u);
  for (std::uint64_t k = 0; k < 100; ++k) {
    EXPECT_EQ(own.contact(k).scene.friction, three.contact(k).scene.friction);
    EXPECT_EQ(own.contact(k).scene.sensor, few.contact(k).scene.sensor);
  }
}

TEST(SceneSource, OwnSensorsNeedPatches) {
  SceneSource sweep = source(head + load + parabola + own_sensor);
  sweep.model_on(rung_named("patch-8"));
  EXPECT_TRUE(sweep.own_sensors());
  EXPECT_THAT([&] { sweep.model_on(rung_named("mesh-161")); },
              ::testing::ThrowsMessage<ConfigError>(::testing::HasSubstr("[sweep] sensors")));
}

TEST(SceneSource, RefusesWithFileLineAndKey) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"[sweep]\nseed = 1\n" + load + parabola, "sweep.contacts = (missing)"},
      {"[sweep]\ncontacts = 0\n" + load + parabola, "sweep.toml:2: sweep.contacts = 0"},
      {head + load + parabola + "[contact]\nfriction = { uniform = [-1, 1] }\n", ":12: contact.friction"},
      {head + load + "[indenter]\nshape = \"parabola\"\nradius = { uniform = [-1, 1] }\n", ":10: indenter.radius"},
      {head + load + "[indenter]\nshape = \"parabola\"\nradius = { uniform = [1, 1e30] }\n", ":10: indenter.radius"},
      {head + load + parabola + "[sensor]\ncolumns = { choice = [41, 51] }\n", "sensor.columns"},
      {head + load + parabola + "[sensor]\npoisson = { uniform = [0.4, 0.5] }\n", ":12: sensor.poisson"},
      {head + load + parabola + own_sensor + "columns = 41\n", "sweep.sensors"},
      {head + load + parabola + own_sensor + "tactel_width = 0.5\n", ":16: sensor.tactel_width"},
      {head + load + parabola + "[sensor]\nlength = { uniform = [8, 20] }\n", ":12: sensor.length"},
      {head + load + parabola + "weight = -1\n", "indenter.weight"},
      {head + load + "[[indenter]]\nshape = \"parabola\"\nradius = 1\nweight = 0\n", "indenter.weight"},
      {head + load + "[indenter]\nshape = \"profile\"\npoints = 2\nhalf_width = 1\nheight = 1\n", "indenter.points"},
      {head + parabola + "[load]\nindentation = 0.1\nslip_index = 0.5\n", "load.slip_index"},
      {head + load + parabola + "[contact]\nfrction = 1\n", "did you mean friction?"},
      {head + load, "indenter.shape = (missing)"},
      {"title = \"a\\u001b[31m\"\n" + head + load + parabola, "sweep.toml:1: title = "},
      {head + load + parabola + "name = \"x\"\n", "indenter.name"},
      {"indenter = 3\n" + head + load, "sweep.toml:1: indenter = 3: must be a table"},
      {"load = []\n" + head + parabola, "sweep.toml:1: load = []: must be a table"},
      {"load = [1, 2]\n" + head + parabola, "sweep.toml:1: load = [1, 2]: must be a table"},
      {"contact = \"x\"\n" + head + load + parabola, "sweep.toml:1: contact = \"x\": must be a table"}};
  for (const auto& [text, said] : refused)
    EXPECT_NE(message_of(text).find(said), std::string::npos) << text << message_of(text);
}

TEST(EndTactels, StandAtTheEndsOfTheBase) {
  fem::Sensor sensor;
  EXPECT_TRUE(tactels_at_ends(sensor)) << "the default";
  sensor.tactel_span = 19;
  EXPECT_FALSE(tactels_at_ends(sensor));
  sensor.tactel_span = sensor.length;
  EXPECT_TRUE(tactels_at_ends(sensor));
  sensor.tactel_span.reset(), sensor.tactel_width = 0.5;
  EXPECT_FALSE(tactels_at_ends(sensor)) << "the mean over a width is finite";
  sensor.tactels = 1, sensor.tactel_width = 0;
  EXPECT_FALSE(tactels_at_ends(sensor)) << "one stands in the middle";
}

}  // namespace tactel::host::scene_source_test
