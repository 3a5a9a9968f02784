// SPDX-License-Identifier: Apache-2.0

// Numbers in another unit than the file's: a modulus in Pa or GPa, lengths in m or um.
#include "host/scenes/unit_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "host/scenes/scene_file.h"
#include "host/scenes/sweep_file.h"
#include "tests/host/scenes/sweep_text.h"

namespace tactel::host::unit_warnings_test {

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
  scene.sensor.young = 2, scene.indenter.young = 1.5e6;
  EXPECT_THAT(unit_warnings(scene),
              ElementsAre("indenter.young = 1.5e+06 MPa: usual are 0.001 to 1000 MPa; check the unit"));
  scene.indenter.young = 1.5, scene.sensor.curvature_radius = 0.015;
  EXPECT_THAT(unit_warnings(scene), ElementsAre(StartsWith("sensor.curvature_radius = 0.015 mm: usual are")));
  scene.sensor.curvature_radius.reset();
  scene.sensor.thickness = 2e-3, scene.sensor.length = scene.sensor.width = 0.02;
  scene.indenter.shape = fem::Punch{0.002};
  EXPECT_THAT(unit_warnings(scene), ElementsAre(StartsWith("sensor.thickness"), StartsWith("sensor.length"),
                                                StartsWith("sensor.width"), StartsWith("indenter.radius")));
}

/// A bowl of radius 10 mm on 31 x 31 points, 0.2 mm apart, as a scan of a sphere gives it; `change` spoils it.
fem::PadScene with_scan(const std::function<void(Eigen::MatrixXd&)>& change, double pitch = 0.2) {
  fem::HeightMap map{.pitch = pitch, .heights = Eigen::MatrixXd(31, 31), .file = "scan.csv"};
  for (int i = 0; i < 31; ++i)
    for (int j = 0; j < 31; ++j) map.heights(i, j) = 0.2 * 0.2 * ((i - 15) * (i - 15) + (j - 15) * (j - 15)) / 20.0;
  change(map.heights);
  map.heights.array() -= map.heights.minCoeff();
  fem::PadScene scene;
  scene.indenter.shape = map;
  scene.load.indentation = {0.1};
  return scene;
}

TEST(UnitWarnings, OfMeasuredHeights) {
  const auto of = [](const std::function<void(Eigen::MatrixXd&)>& change, double pitch = 0.2) {
    return unit_warnings(with_scan(change, pitch));
  };
  EXPECT_THAT(of([](Eigen::MatrixXd&) {}), IsEmpty());
  EXPECT_THAT(of([](Eigen::MatrixXd& h) { h = -h; }), ElementsAre(HasSubstr("upside down")));
  EXPECT_THAT(of([](Eigen::MatrixXd& h) { h *= 1e-3; }, 0.2e-3),
              ElementsAre(StartsWith("indenter's measured width = 0.006 mm"), HasSubstr("at the border")));
  EXPECT_THAT(of([](Eigen::MatrixXd& h) { h *= 1e3; }, 200),
              ElementsAre(StartsWith("indenter's measured width = 6000")));
  EXPECT_THAT(of([](Eigen::MatrixXd& h) { h *= 20; }), ElementsAre(HasSubstr("span 18 mm over a width of 6 mm")));
  for (const double spike : {0.8, -0.8})
    EXPECT_THAT(of([spike](Eigen::MatrixXd& h) { h(16, 9) += spike; }),
                ElementsAre(AllOf(HasSubstr("height 17 of line 10 is 0.7"), HasSubstr("fill it"))));
}

// Smooth, rough, stepped and pointed shapes are what was measured.
TEST(UnitWarnings, WhatIsMeasuredPasses) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 200; ++k) {
    const double rough = std::pow(10, -4 + 0.015 * k), step = 0.3 * (k % 3);  // mm
    const auto spoilt = [&](Eigen::MatrixXd& h) {
      for (double& height : h.reshaped()) height += rough * normal(random);
      h.block(5, 8, 9, 4).array() -= step;            // a raised letter
      h.row(0).array() += 1, h.row(30).array() += 1;  // no contact at the border
      h.col(0).array() += 1, h.col(30).array() += 1;
    };
    EXPECT_THAT(unit_warnings(with_scan(spoilt)), IsEmpty()) << k;
  }
  for (const double power : {0.7, 1.0, 4.0})
    EXPECT_THAT(unit_warnings(with_scan([power](Eigen::MatrixXd& h) { h = h.array().pow(power / 2); })), IsEmpty());
}

TEST(UnitWarnings, OfMeasuredProfiles) {
  const auto of = [](double unit, double depth) {
    fem::Profile profile{{}, {}, 0, "line.csv"};
    for (int i = -40; i <= 40; ++i) profile.x.push_back(0.1 * i * unit), profile.y.push_back(0.01 * i * i / 20 * unit);
    fem::Scene scene{.indenter = {.shape = profile}};
    scene.load.indentation = {depth};
    return unit_warnings(scene);
  };
  EXPECT_THAT(of(1, 0.1), IsEmpty());
  EXPECT_THAT(of(1000, 0.1), ElementsAre(StartsWith("indenter's measured width = 8000 mm: usual are 0.1 to 1000 mm")));
  EXPECT_THAT(of(0.001, 0.1), ElementsAre(StartsWith("indenter's measured width = 0.008"), HasSubstr("at the border")));
  EXPECT_THAT(of(1, 0.8), ElementsAre(HasSubstr("at the border")));
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

}  // namespace tactel::host::unit_warnings_test
