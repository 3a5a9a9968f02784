// SPDX-License-Identifier: Apache-2.0

// tactel calibrate plan as a user runs it, and what it writes for tactel calibrate sensor.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "fem/layer/patch_solver.h"
#include "host/live/sensor_profile.h"
#include "host/scenes/scene_file.h"
#include "tests/host/commands/recorded_sensor.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

using ::testing::HasSubstr;

class CalibratePlan : public ::testing::Test {
 protected:
  CalibratePlan() {
    folder_.write("p.toml", std::string(RecordedSensor::format) +
                                "[calibration]\ngain = 0.01\nnoise = 0.3\n[channels]\n"
                                "normal = [0, 1, 2, 3, 4, 5, 6, 7]\nshear = [8, 9, 10, 11, 12, 13, 14, -1]\n");
    folder_.write("rod.toml",
                  "[sensor]\ntactels = 8\n[indenter]\nshape = \"cylinder\"\nradius = 12\n[contact]\nfriction = 0.6\n"
                  "[load]\nindentation = 0.15\ntangential = [0.03, 0.06]\n");
    folder_.write("list.toml", list);
  }

  ChildResult plan(std::vector<std::string> more) const {
    return run_tactel({"calibrate", "plan", (folder_ / "p.toml").string()}, more);
  }

  const std::string list =
      "[fit]\npoisson = false\n[transducer]\ntime_constant = 20\n"
      "[rod]\nscene = \"rod.toml\"\nposition = [-7, -3.5, 0, 3.5, 7]\nindentation = [0.1, 0.15]\ndrag = [0, 0.06]\n";
  ScratchFolder folder_;
};

TEST_F(CalibratePlan, WritesPressesToRecord) {
  const std::string output = (folder_ / "my plan.toml").string(), json = (folder_ / "plan.json").string();
  const ChildResult result =
      plan({"--candidates", (folder_ / "list.toml").string(), "--presses", "6", "--output", output, "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("sensor.young"));
  EXPECT_THAT(result.out, HasSubstr("sensor.thickness is held"));
  const nlohmann::json found = nlohmann::json::parse(std::ifstream(json));
  EXPECT_EQ(found["candidates"], 20);
  ASSERT_EQ(found["presses"].size(), 6u);
  EXPECT_EQ(found["noise"][0], 0.003);  // 0.3 units of 0.01 MPa
  EXPECT_TRUE(found["noise"][15].is_null());
  EXPECT_TRUE(found["planned"]["poisson"].is_null());
  for (int k = 1; k <= 6; ++k) {
    const fem::Scene scene = read_scene(folder_ / ("my plan-0" + std::to_string(k) + ".toml"));
    const nlohmann::json& json_scene = found["presses"][k - 1]["scene"];
    EXPECT_EQ(scene.indenter.position, json_scene["indenter"]["position"]);
    EXPECT_EQ(scene.sensor.tactels, 8);
    EXPECT_EQ(scene.friction, 0.6);
    EXPECT_EQ(scene.load.indentation.size(), 1u);
  }
  // The file is read as far as the recordings, which are not there yet.
  const ChildResult next = run_tactel({"calibrate", "sensor", output, "--profile", (folder_ / "p.toml").string(),
                                       "--output", (folder_ / "p2.toml").string()});
  EXPECT_NE(next.exit_code, 0);
  EXPECT_THAT(next.err, HasSubstr("my plan-01.tactel"));
}

/// Plan, record each press as the plan's file says, fill in P, calibrate: the new profile has the sensor's gains.
TEST_F(CalibratePlan, LeadsToACalibratedProfile) {
  constexpr double true_young = 2.6;
  folder_.write("list.toml",
                "[fit]\npoisson = false\n"
                "[rod]\nscene = \"rod.toml\"\nposition = [-7, -5, -3, -1, 1, 3, 5, 7]\n"
                "indentation = [0.1, 0.15]\ndrag = [0, 0.06, -0.06]\n");
  const std::string output = (folder_ / "plan.toml").string(), calibrated = (folder_ / "p2.toml").string(),
                    json = (folder_ / "c.json").string();
  ASSERT_EQ(plan({"--candidates", (folder_ / "list.toml").string(), "--presses", "6", "--output", output}).exit_code,
            0);
  RecordedSensor sensor;
  std::string text = text_of(output);
  for (int k = 1; k <= 6; ++k) {
    const std::string name = (folder_ / ("plan-0" + std::to_string(k))).string();
    fem::Scene scene = read_scene(name + ".toml");
    scene.sensor.young = true_young;
    static const fem::LayerModel model = fem::layer_model(scene.sensor);
    const fem::ContactSolution truth = fem::PatchSolver(model, {.elements = 24, .tolerance = 1e-8}).solve(scene);
    const std::string P = sensor.record(name + ".tactel", truth.steps, 100, 100), empty = "# P = [ ]";
    const std::size_t place = text.find(empty);
    ASSERT_NE(place, std::string::npos) << text;
    text.replace(place, empty.size(), "P = [" + P + "]");
  }
  folder_.write("plan.toml", text);
  const ChildResult result = run_tactel({"calibrate", "sensor", output, "--profile", (folder_ / "p.toml").string(),
                                         "--output", calibrated, "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err << result.out;
  const nlohmann::json found = nlohmann::json::parse(std::ifstream(json));
  EXPECT_NEAR(found["young"]["value"].get<double>(), true_young, 0.03);
  const hw::Calibration calibration = read_profile(calibrated).map.calibration;
  for (std::size_t c = 0; c + 1 < RecordedSensor::channels; ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    if (c % RecordedSensor::tactels == 0 || c % RecordedSensor::tactels == 7) continue;  // over the block's corners
    EXPECT_NEAR(calibration.gain[c] / sensor.gain[i], 1, 0.03) << c;  // noise / sqrt(20) of some 0.1 MPa
  }
  EXPECT_EQ(calibration.gain[15], 0.01) << "no tactel uses it";
}

/// The sensor of docs/how-to.md, with eight tactels.
TEST_F(CalibratePlan, TactelsMayHaveAWidth) {
  folder_.write("wide.toml",
                "[sensor]\nlength = 30\nthickness = 2.5\nyoung = 1.2\npoisson = 0.48\ntactels = 8\ntactel_span = 22\n"
                "tactel_width = 1.5\n[indenter]\nshape = \"cylinder\"\nradius = 12\n[contact]\nfriction = 0.6\n"
                "[load]\nindentation = 0.2\ntangential = [0.05]\n");
  folder_.write("list.toml", "[fit]\npoisson = false\n[rod]\nscene = \"wide.toml\"\nposition = [-10, -5, 0, 5, 10]\n");
  const std::string output = (folder_ / "plan.toml").string();
  ASSERT_EQ(plan({"--candidates", (folder_ / "list.toml").string(), "--presses", "4", "--output", output}).exit_code,
            0);
  EXPECT_EQ(read_scene(folder_ / "plan-01.toml").sensor.tactel_width, 1.5);
}

TEST_F(CalibratePlan, WrongFilesAreNamed) {
  const std::string file = (folder_ / "list.toml").string();
  const auto refused = [&](const std::string& text, const std::string& message, std::vector<std::string> more = {}) {
    folder_.write("list.toml", text);
    more.insert(more.end(), {"--candidates", file});
    EXPECT_TRUE(is_refused(plan(more), {message}));
  };
  refused("[fit]\npoisson = false\n", "at least one table of candidates");
  refused("[rod]\nposition = 1\n", "rod.scene");
  refused("[rod]\nscene = \"rod.toml\"\nplaces = 1\n", "rod.places");
  refused("[rod]\nscene = \"rod.toml\"\nposition = [0, 99]\n", "rod: indenter.position");
  refused("[rod]\nscene = \"rod.toml\"\nindentation = 1\nnormal_force = 1\n", "rod.normal_force");
  refused("[fit]\ntime_constant = true\n[rod]\nscene = \"rod.toml\"\n", "transducer.time_constant");
  refused("[transducer]\ntime_constant = 0\n[rod]\nscene = \"rod.toml\"\n", "transducer.time_constant");
  refused("[fit]\nfriction = 2\n[rod]\nscene = \"rod.toml\"\n", "fit.friction");
  refused("[fit]\npoisson = false\n[rod]\nscene = \"rod.toml\"\n", "--presses");
  folder_.write("three.toml",
                "[sensor]\ntactels = 3\n[indenter]\nshape = \"cylinder\"\nradius = 12\n[contact]\nfriction = 0.6\n"
                "[load]\nindentation = 0.15\n");
  refused("[rod]\nscene = \"three.toml\"\n", "the profile's 8 tactels");
  EXPECT_THAT(plan({"--scene", (folder_ / "three.toml").string()}).err, HasSubstr("the profile's 8 tactels"));
}

}  // namespace
}  // namespace tactel::host
