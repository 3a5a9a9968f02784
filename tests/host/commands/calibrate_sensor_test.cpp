// SPDX-License-Identifier: Apache-2.0

// tactel calibrate sensor as a user runs it: recordings of presses on a simulated sensor with unknown gains and E.
#include <gmock/gmock.h>

#include <fstream>

#include "fem/layer/patch_solver.h"
#include "host/live/sensor_profile.h"
#include "tests/host/commands/live_command.h"
#include "tests/host/commands/recorded_sensor.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int tactels = RecordedSensor::tactels;
constexpr double true_young = 2.6;

class CalibrateSensor : public ::testing::Test {
 protected:
  CalibrateSensor() {
    write(profile_, std::string("# keep me\n[device]\nname = \"test\"\n") + RecordedSensor::format +
                        "[calibration]\ngain = 0.01\n[channels]\n"
                        "normal = [0, 1, 2, 3, 4, 5, 6, 7]\nshear = [8, 9, 10, 11, 12, 13, 14, 15]\n");
    std::string presses = "[fit]\npoisson = false\n";
    for (int k = 0; k < 6; ++k) presses += press(k);
    write(recordings_, presses);
  }

  static void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

  /// Half a second at rest, then half a second on each load step. Returns the press's table.
  std::string press(int k) {
    const std::string name = "press" + std::to_string(k), file = (folder_ / name).string();
    const fem::Scene scene{.sensor = {.young = true_young, .tactels = tactels},
                           .indenter = {fem::Cylinder{12}, -7.0 + 2.8 * k},
                           .friction = 0.6,
                           .load = {.indentation = {0.15}, .tangential = {0.03, 0.06}}};
    write(file + ".toml",
          "[sensor]\ntactels = 8\nyoung = 2.0\nmodel = \"patch\"\n[indenter]\nshape = \"cylinder\"\nradius = 12\n"
          "position = " +
              std::to_string(scene.indenter.position) +
              "\n[contact]\nfriction = 0.6\n[load]\nindentation = 0.15\ntangential = [0.03, 0.06]\n");
    static const fem::LayerModel model = fem::layer_model(scene.sensor);
    const fem::ContactSolution solution = fem::PatchSolver(model, {.elements = 24, .tolerance = 1e-8}).solve(scene);
    const std::string P = sensor_.record(file + ".tactel", solution.steps, 50, 50);
    return "[" + name + "]\nscene = \"" + name + ".toml\"\nrecording = \"" + name +
           ".tactel\"\ntimes = [0.75, 1.25, 1.75]\nwindow = 0.3\nP = [" + P + "]\n";
  }

  ChildResult calibrate(std::vector<std::string> more = {}) const {
    return run_tactel({"calibrate", "sensor", recordings_, "--profile", profile_, "--output", output_}, more);
  }

  ScratchFolder folder_;
  RecordedSensor sensor_;
  std::string profile_ = (folder_ / "p.toml").string(), recordings_ = (folder_ / "r.toml").string(),
              output_ = (folder_ / "p2.toml").string();
};

TEST_F(CalibrateSensor, WritesAProfileWithTheGainsOfTheSensor) {
  const std::string json = (folder_ / "c.json").string(), html = (folder_ / "c.html").string(),
                    plot = (folder_ / "c.svg").string();
  const ChildResult result = calibrate({"--json", json, "--html", html, "--plot", plot});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("sensor.young = 2.6"));
  const std::string page = text_of(html);
  for (const char* part : {"Gains of 16 of 16 transducers", "shear stress of tactel 7", "sensor.thickness is held"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
  EXPECT_THAT(text_of(plot), HasSubstr("<svg"));
  EXPECT_THAT(result.out, HasSubstr("sensor.thickness is held"));
  const SensorProfile profile = read_profile(output_);
  EXPECT_THAT(profile.text, HasSubstr("# keep me\n"));
  for (std::size_t c = 1; c + 1 < 2 * tactels; ++c) {
    if (c == tactels - 1 || c == tactels) continue;  // over a lower corner of the block, where stress is singular
    const auto i = static_cast<Eigen::Index>(c);
    EXPECT_NEAR(profile.map.calibration.gain[c] / sensor_.gain[i], 1, 0.03) << c;  // noise / sqrt(30) of some 0.1 MPa
    EXPECT_NEAR((profile.map.calibration.offset[c] - sensor_.offset[i]) * sensor_.gain[i], 0, 0.003) << c;
  }
  const nlohmann::json found = nlohmann::json::parse(std::ifstream(json));
  EXPECT_TRUE(found["converged"].get<bool>());
  EXPECT_NEAR(found["young"]["value"].get<double>(), true_young, 0.03);
  EXPECT_EQ(found["gain"].size(), 2u * tactels);
  EXPECT_EQ(found["residuals"].size(), 6u);
}

/// The touch threshold and drift of monitor take the noise of the new profile, without a tare.
TEST_F(CalibrateSensor, WritesTheNoiseAtRestForMonitor) {
  const std::string json = (folder_ / "c.json").string(), rest = (folder_ / "rest.tactel").string(),
                    network_file = (folder_ / "n.onnx").string();
  const ChildResult result = calibrate({"--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("transducer.noise = 0.00"));
  EXPECT_THAT(result.out, Not(HasSubstr("tare with this profile")));
  const hw::Calibration calibration = read_profile(output_).map.calibration;
  const nlohmann::json found = nlohmann::json::parse(std::ifstream(json));
  ASSERT_EQ(calibration.noise.size(), 2u * tactels);
  // A median of 18 windows of 30 frames scatters by sqrt(0.83 pi / 2 / 540) = 5 %; three of these.
  for (std::size_t c = 0; c < 2 * tactels; ++c) {
    EXPECT_NEAR(calibration.noise[c] * sensor_.gain[static_cast<Eigen::Index>(c)] / RecordedSensor::noise, 1, 0.15)
        << c;
    EXPECT_NEAR(found["rest_noise"][c].get<double>(), calibration.noise[c], 1e-6 * calibration.noise[c]) << c;
  }
  sensor_.record(rest, {}, 900, 0);
  write_onnx(network_file, network(tactels));
  const auto monitor = [&](const std::string& profile) {
    return run_tactel({"monitor", "--source", "replay:" + rest, "--network", network_file, "--profile", profile});
  };
  const ChildResult watched = monitor(output_);
  ASSERT_EQ(watched.exit_code, 0) << watched.err;
  for (const nlohmann::json& line : lines_of(watched.out)) EXPECT_EQ(line["contact"], false) << line;
  EXPECT_THAT(watched.err, HasSubstr("\"drifts\": 0"));
  EXPECT_FALSE(lines_of(monitor(profile_).out).front().contains("contact")) << "that profile has no noise";
}

/// With nu unknown, too: eight blocks of free sides, some seconds without a cache.
using CalibrateSensorNightly = CalibrateSensor;
TEST_F(CalibrateSensorNightly, PoissonIsFoundByDefault) {
  const std::string text = text_of(recordings_);
  write(recordings_, text.substr(text.find("[press0]")));
  const std::string json = (folder_ / "c.json").string();
  const ChildResult result = calibrate({"--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err << result.out;
  const nlohmann::json found = nlohmann::json::parse(std::ifstream(json));
  const auto within = [&](const char* name, double value, double model) {
    EXPECT_NEAR(found[name]["value"].get<double>(), value, 3 * found[name]["deviation"].get<double>() + model) << name;
  };
  within("poisson", 0.45, 0.002);  // the family's tables and the sensor's own differ by 0.1 % of a stress
  within("young", true_young, 0.02);
}

TEST_F(CalibrateSensor, WrongFilesAreNamed) {
  const auto refused = [&](const std::string& text, const std::string& message) {
    write(recordings_, text);
    EXPECT_TRUE(is_refused(calibrate(), {message}));
    EXPECT_FALSE(std::filesystem::exists(output_));
  };
  const std::string press = "[a]\nscene = \"press0.toml\"\nrecording = \"press0.tactel\"\n";
  refused("[fit]\n", "at least one table of a press");
  refused("[a]\nscene = \"press0.toml\"\n", "a.recording");
  refused(press + "times = [1, 2]\n", "load steps, 3");
  refused(press + "times = [1, 1.5, 9]\n", "9 s has no frame");
  refused(press + "times = [1, 1.5, 1.9]\nP = [1]\n", "as long as times, 3");
  refused(press + "times = [1, 1.5, 1.9]\nforce = 2\n", "a.force");
  const std::string timed = press + "times = [1, 1.5, 1.9]\n";
  for (const char* P : {"[0, 0.5, 0.5]", "[0.5, -1, 0.5]"}) refused(timed + "P = " + P + "\n", "a.P");
  for (const char* window : {"1e9", "0", "-1", "0.5"}) refused(timed + "window = " + window + "\n", "a.window");
  refused(press + "times = [1, 1.9, 1.5]\n", "each later than the one before");
  refused(timed + "begin = [0.9, 1.2, 1.6]\nend = [0.8, 1.4, 1.8]\n", "s, not before begin");
  refused("[fit]\nforce_noise = 1e308\n" + timed, "fit.force_noise");
  refused("[fit]\nforce_noise = 0\n" + press + "times = [1, 1.5, 1.9]\n", "fit.force_noise");
}

}  // namespace
}  // namespace tactel::host
