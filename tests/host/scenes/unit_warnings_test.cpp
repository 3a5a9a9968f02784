// SPDX-License-Identifier: Apache-2.0

// Numbers in another unit than the file's: a modulus in Pa or GPa, lengths in m or um.
#include "host/scenes/unit_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/scenes/scene_file.h"
#include "host/scenes/sweep_file.h"
#include "tests/host/scenes/sweep_text.h"

namespace tactel::host {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

fem::Scene scene_with(double young, double thickness, double length = 20, double radius = 10) {
  return {.sensor = {.length = length, .thickness = thickness, .young = young},
          .indenter = {.shape = fem::Parabola{radius}}};
}

TEST(UnitWarnings, ModuliAndLengthsOfOtherUnitsAreNamed) {
  EXPECT_THAT(unit_warnings(scene_with(2, 1.5)), IsEmpty());
  EXPECT_THAT(unit_warnings(scene_with(0.01, 0.05)), IsEmpty());
  EXPECT_THAT(unit_warnings(scene_with(100, 50, 200)), IsEmpty());
  for (const double young : {2e6, 0.002, 100.1, 0.0099})  // Pa, GPa
    EXPECT_THAT(unit_warnings(scene_with(young, 1.5)), ElementsAre(AllOf(StartsWith("sensor.young"), HasSubstr("MPa"))))
        << young;
  for (const double meter : {1e-3, 1e3})  // all lengths in m, or in um
    EXPECT_THAT(unit_warnings(scene_with(2, 1.5 * meter, 20 * meter, 10 * meter)),
                ElementsAre(AllOf(StartsWith("sensor.thickness"), HasSubstr(" mm:")), StartsWith("sensor.length"),
                            StartsWith("indenter.radius")))
        << meter;
  EXPECT_EQ(unit_warnings(scene_with(2e6, 1.5))[0],
            "sensor.young = 2e+06 MPa: usual are 0.01 to 100 MPa; check the unit");
}

TEST(UnitWarnings, OfPads) {
  fem::PadScene scene;
  scene.sensor.length = scene.sensor.width = 20;
  EXPECT_THAT(unit_warnings(scene), IsEmpty());
  scene.sensor.young = 2e6;
  EXPECT_THAT(unit_warnings(scene), ElementsAre("sensor.young = 2e+06 MPa: usual are 0.01 to 100 MPa; check the unit"));
  scene.sensor.young = 2;
  scene.sensor.thickness = 2e-3, scene.sensor.length = scene.sensor.width = 0.02;
  scene.indenter.shape = fem::Punch{0.002};
  EXPECT_THAT(unit_warnings(scene), ElementsAre(StartsWith("sensor.thickness"), StartsWith("sensor.length"),
                                                StartsWith("sensor.width"), StartsWith("indenter.radius")));
}

TEST(UnitWarnings, OfManyTheFirstIsNamed) {
  const std::vector<fem::Scene> scenes = {scene_with(2, 1.5), scene_with(2e6, 1.5), scene_with(3e6, 0.0015)};
  EXPECT_THAT(unit_warnings(scenes),
              ElementsAre(StartsWith("scenes[1]: sensor.young"), StartsWith("scenes[2]: sensor.thickness")));
}

// A sensor of the file, sensors that are drawn once, and sensors and indenters that each contact draws.
TEST(UnitWarnings, OfSweeps) {
  const auto of = [](const std::string& sensor, const std::string& radius = "10") {
    return unit_warnings(source("[sweep]\ncontacts = 200\n" + sensor + "\n[indenter]\nshape = \"parabola\"\nradius = " +
                                radius + "\n[load]\nindentation = 0.1\n"));
  };
  EXPECT_THAT(of(""), IsEmpty());
  EXPECT_THAT(of("[sensor]\nyoung = 2e6"), ElementsAre(StartsWith("sensor.young = 2e+06")));
  EXPECT_THAT(of("sensors = 8\n[sensor]\nyoung = { uniform = [1, 1e6] }"), ElementsAre(StartsWith("sensor.young")));
  EXPECT_THAT(of("[sensor]\nyoung = { uniform = [1, 1e6] }"), ElementsAre(StartsWith("sensor.young")));
  EXPECT_THAT(of("", "{ uniform = [0.002, 0.01] }"), ElementsAre(StartsWith("indenter.radius")));
}

TEST(UnitWarnings, NoExampleHasOne) {
  for (const auto& file : std::filesystem::directory_iterator(source_file("examples"))) {
    if (file.path().extension() != ".toml") continue;
    SCOPED_TRACE(file.path());
    const bool sweep = text_of(file.path()).find("[sweep]") != std::string::npos;
    if (sweep) {
      EXPECT_THAT(unit_warnings(read_sweep(file.path()).source), IsEmpty());
      continue;
    }
    EXPECT_THAT(std::visit([](const auto& scene) { return unit_warnings(scene); }, read_any_scene(file.path())),
                IsEmpty());
  }
}

}  // namespace
}  // namespace tactel::host
