// SPDX-License-Identifier: Apache-2.0

// tactel calibrate sensor as a user runs it: recordings of presses on a simulated sensor with unknown gains and E.
#include <gmock/gmock.h>

#include <fstream>
#include <random>

#include "fem/layer/patch_solver.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_solver.h"
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
  EXPECT_TRUE(is_refused(monitor(profile_), {"--calibration", "no reading at rest"}));
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

/// A pad as the built-in profile uskin-4x4 has it, which counts lines of x, y, z of each tactel.
class CalibratePad : public ::testing::Test {
 protected:
  static constexpr int tactels = 16;
  static constexpr double young = 0.6, noise = 2e-4;  // MPa

  CalibratePad() {
    std::normal_distribution<double> normal;
    for (double& g : gain_) g = 1e-5 * (1 + 0.15 * normal(random_));
    for (double& o : offset_) o = 20000 + 100 * normal(random_);
    std::string presses = "[fit]\npoisson = false\n";
    for (int k = 0; k < 5; ++k) presses += press(k);
    folder_.write("r.toml", presses);
  }

  /// A third of a second at rest and on each load step. Returns the press's table.
  std::string press(int k) {
    const std::string name = "press" + std::to_string(k);
    const fem::PadScene scene{.title = "",
                              .sensor = {.thickness = 4, .young = young, .poisson = 0.46},
                              .indenter = {.shape = fem::Sphere{10},
                                           .position = {k < 4 ? 4.0 * (k % 2) - 3 : 1, k < 4 ? 4.0 * (k / 2) - 2 : 1}},
                              .friction = 0.8,
                              .load = {.indentation = {1.0}, .drags = {{0.2, 0, 0}, {0.2, 0.2, 0}}}};
    folder_.write(name + ".toml",
                  "[sensor]\nkind = \"pad\"\nthickness = 4\nyoung = 0.5\npoisson = 0.46\n[indenter]\n"
                  "shape = \"sphere\"\nradius = 10\nposition = [" +
                      std::to_string(scene.indenter.position[0]) + ", " + std::to_string(scene.indenter.position[1]) +
                      "]\n[contact]\nfriction = 0.8\n[load]\nindentation = 1.0\n"
                      "tangential = [[0.2, 0], [0.2, 0.2]]\n");
    const fem::PadSolution solution =
        fem::PadSolver(fem::pad_layer(0.46), {.cells = 16, .tolerance = 1e-5, .ladder = false}).solve(scene);
    std::ofstream lines(folder_ / (name + ".csv"));
    std::normal_distribution<double> normal;
    lines << "time";
    for (int c = 0; c < 3 * tactels; ++c) lines << ",c" << c;
    for (int frame = 0; frame < 120; ++frame) {
      lines << '\n' << 0.01 * frame;
      for (int c = 0; c < 3 * tactels; ++c) {
        const int axis = (c % 3 + 1) % 3;  // x, y, z to sigma_z, tau_x, tau_y
        const double stress =
            frame < 30 ? 0 : solution.steps[static_cast<std::size_t>(frame / 30 - 1)].stress(c / 3, axis);
        lines << ',' << (axis == 0 ? -1 : 1) * (stress + noise * normal(random_)) / gain_[c] + offset_[c];
      }
    }
    lines << '\n';
    lines.close();
    const ChildResult recorded =
        run_tactel({"record", "--source", "csv:" + (folder_ / (name + ".csv")).string(), "--profile", "uskin-4x4",
                    "--output", (folder_ / (name + ".tactel")).string()});
    EXPECT_EQ(recorded.exit_code, 0) << recorded.err;
    std::string P;
    for (const fem::PadStep& step : solution.steps) P += (P.empty() ? "" : ", ") + std::to_string(step.P);
    return "[" + name + "]\nscene = \"" + name + ".toml\"\nrecording = \"" + name +
           ".tactel\"\ntimes = [0.45, 0.75, 1.05]\nwindow = 0.2\nP = [" + P + "]\n";
  }

  ChildResult calibrate(const std::string& profile, std::vector<std::string> more = {}) const {
    return run_tactel({"calibrate", "sensor", (folder_ / "r.toml").string(), "--profile", profile, "--output",
                       (folder_ / "p2.toml").string()},
                      std::move(more));
  }

  ScratchFolder folder_;
  std::mt19937 random_{11};
  Eigen::VectorXd gain_{3 * tactels}, offset_{3 * tactels};  ///< of the channels
};

TEST_F(CalibratePad, WritesAProfileWithTheGainsOfThreeAxes) {
  const std::string json = (folder_ / "c.json").string(), html = (folder_ / "c.html").string();
  const ChildResult result = calibrate("uskin-4x4", {"--json", json, "--html", html});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json found = nlohmann::json::parse(std::ifstream(json));
  EXPECT_NEAR(found["young"]["value"].get<double>(), young, 3 * found["young"]["deviation"].get<double>());
  ASSERT_EQ(found["gain"].size(), 3u * tactels);
  EXPECT_EQ(found["shift_y"]["deviation"], 0) << "held";
  EXPECT_THAT(text_of(html), HasSubstr("shear stress along y of tactel 15"));
  const SensorProfile profile = read_profile(folder_ / "p2.toml");
  ASSERT_EQ(profile.pads.size(), 1u);
  for (int c = 0; c < 3 * tactels; ++c) {
    const int place = (c % 3 + 1) % 3 * tactels + c / 3;
    const double deviation = found["gain"][static_cast<std::size_t>(place)]["deviation"].get<double>();
    const double gain = profile.map.calibration.gain[static_cast<std::size_t>(c)];
    EXPECT_NEAR(gain, (c % 3 == 2 ? -1 : 1) * gain_[c], 4 * deviation) << c;  // 6e-5 of a normal distribution
    EXPECT_LT(deviation, 0.15 * gain_[c]) << c;
  }
}

TEST_F(CalibratePad, WrongProfilesAndScenesAreNamed) {
  EXPECT_TRUE(
      is_refused(calibrate("uskin-4x6"), {"press0.scene", "a scene of a pad with the profile's 4 x 6 tactels"}));
  folder_.write("line.toml", "[format]\nkind = \"csv\"\nchannels = 48\n[channels]\nnormal = [0, 1]\n");
  EXPECT_TRUE(is_refused(calibrate((folder_ / "line.toml").string()),
                         {"press0.scene", "a scene of a line with the profile's 2 tactels"}));
  EXPECT_TRUE(is_refused(run_tactel({"calibrate", "plan", "uskin-4x4"}), {"calibrate plan serves lines"}));
}

}  // namespace
}  // namespace tactel::host
