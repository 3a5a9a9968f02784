// SPDX-License-Identifier: Apache-2.0

// tare --hold and monitor --rest as a user runs them: without a network, on lines of numbers and on a simulated grip.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>

#include "tests/host/commands/live_command.h"

namespace tactel::host::rest_command_test {

using ::testing::HasSubstr;

/// Two pads of two tactels with three axes: counts of x, y, z of each. Both read 1000 or 1001 at rest.
class RestCommand : public LiveCommand {
 protected:
  /// Frames of grips, counts less those at rest.
  class Frames {
   public:
    /// normal: of the first tactels of the left and the right pad; the second tactels have a third. shear: of both.
    void add(double left, double right, double shear = 0) {
      std::vector<double> counts;
      for (const double normal : {left, right})
        for (const double share : {1.0, 1.0 / 3})
          counts.insert(counts.end(), {share == 1 && normal > 0 ? shear : 0, 0, normal * share});
      const double rest = left + right == 0 ? 1000 + number_ % 2 : 1000 + 100 / 201.0;  // the mean of 201 frames
      for (double& count : counts) count += rest;
      for (const std::size_t shear : {4u, 10u}) counts[shear] += 5e-4 * (number_ % 2);  // or it were frozen
      text_ += fmt::format("{},{}\n", 0.01 * number_++, fmt::join(counts, ","));
    }
    /// Twenty frames without contact, fifty that press, a hundred that hold.
    void grip(double left, double right) {
      for (int i = 0; i < 20; ++i) add(0, 0);
      for (int i = 1; i < 50; ++i) add(left * i / 50, right * i / 50);
      for (int i = 0; i < 101; ++i) add(left, right);
    }
    const std::string& text() const { return text_; }

   private:
    std::string text_ = "time,a,b,c,d,e,f,g,h,i,j,k,l\n";
    int number_ = 0;
  };

  ChildResult run(const std::string& command, const std::string& file, std::vector<std::string> more = {}) const {
    more.insert(more.end(), {"--profile", profile_, "--profile", profile_});
    return run_tactel({command, "--source", "csv:" + file}, more);
  }
  std::string rest_frames() {
    Frames frames;
    for (int i = 0; i < 300; ++i) frames.add(0, 0);
    return folder_.write("rest.csv", frames.text());
  }
  ChildResult tare(const Frames& hold) {
    return run("tare", rest_frames(),
               {"--output", calibration_, "--hold", "csv:" + folder_.write("hold.csv", hold.text())});
  }
  const std::string calibration_ = folder_ / "c.toml";
  const std::string profile_ =
      folder_.write("pad.toml",
                    "[format]\nkind = \"csv\"\nchannels = 6\n[pad]\ntactels = [2, 1]\npitch = 4\n[channels]\nnormal = "
                    "[2, 5]\nshear_x = [0, 3]\nshear_y = [1, 4]\n[calibration]\ngain = [1e-3, 1e-3, -1e-3, 1e-3, 1e-3, "
                    "-1e-3]\n");
};

// P is 400 counts left and 800 right: 20 counts of shear are 0.05 and 0.025. The threshold is 1.2 times 0.05.
TEST_F(RestCommand, AHoldGivesTheThresholdOfTheAlarm) {
  Frames hold;
  hold.grip(300, 600);
  for (int i = 0; i < 100; ++i) hold.add(300, 600, 20 * std::sin(0.05 * std::numbers::pi * i));
  const ChildResult tared = tare(hold);
  ASSERT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_THAT(tared.err, HasSubstr("the alarm of moved begins at 0.06"));
  EXPECT_THAT(text_of(calibration_), ::testing::ContainsRegex("moved = 0\\.0(6000|59999)"));

  // The shear grows by 0.7 counts a frame: 24 counts are 0.06 of the left pad. After a release half of the grip: 12.
  Frames use;
  use.grip(300, 600);
  for (int i = 0; i < 50; ++i) use.add(300, 600, 0.7 * i);
  use.grip(150, 300);
  for (int i = 0; i < 50; ++i) use.add(150, 300, 0.7 * i);
  const ChildResult said = run("monitor", folder_.write("use.csv", use.text()),
                               {"--calibration", calibration_, "--signal", "moved", "--alarm"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  const auto lines = lines_of(said.out);
  ASSERT_EQ(lines.size(), 2u * 220);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& line = lines[i];
    const int slid = static_cast<int>(i % 220) - 170;
    EXPECT_FALSE(line.contains("slip_index"));
    EXPECT_EQ(line["alarm"], slid >= (i < 220 ? 35 : 18)) << i;
    EXPECT_EQ(line["moved"].is_null(), line["rest"] == false || line["contact"] == false) << i;
    if (slid < -3) continue;
    EXPECT_EQ(line["rest"], true) << i;
    EXPECT_EQ(line["cannot_tell"], false) << i;
    const double left = 0.7 * std::max(slid, 0) / (i < 220 ? 400 : 200);
    EXPECT_NEAR(line["moved"].get<double>(), left, 1e-5) << i;
    EXPECT_NEAR(line["pads"][0]["moved"].get<double>(), left, 1e-5) << i;
    EXPECT_NEAR(line["pads"][1]["moved"].get<double>(), left / 2, 1e-5) << i;
  }
}

// A dead pad has no contact; the other one has its alarm.
TEST_F(RestCommand, ADeadPadIsSilent) {
  Frames hold;
  hold.grip(0, 600);
  for (int i = 0; i < 100; ++i) hold.add(0, 600, 20 * std::sin(0.05 * std::numbers::pi * i));
  ASSERT_EQ(tare(hold).exit_code, 0);
  Frames use;
  use.grip(0, 600);
  for (int i = 0; i < 50; ++i) use.add(0, 600, 0.7 * i);  // 0.03 of 800 is 24
  const auto lines = lines_of(run("monitor", folder_.write("use.csv", use.text()),
                                  {"--calibration", calibration_, "--signal", "moved", "--alarm"})
                                  .out);
  ASSERT_EQ(lines.size(), 220u);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i]["alarm"], i >= 170 + 35) << i;
    EXPECT_EQ(lines[i]["pads"][0]["rest"], false) << i;
  }
}

TEST_F(RestCommand, WhatIsNoHoldIsRefused) {
  Frames never, brief;
  for (int i = 0; i < 100; ++i) never.add(0, 0);
  EXPECT_TRUE(is_refused(tare(never), {"no grip at rest in it", "holds still"}, 3));
  for (int i = 0; i < 20; ++i) brief.add(0, 0);
  for (int i = 0; i < 50; ++i) brief.add(300, 600);
  EXPECT_TRUE(is_refused(tare(brief), {"0.5", "1 s or more"}, 3)) << "20 frames of a window, 31 with a rest at 60 Hz";
  EXPECT_TRUE(
      is_refused(run("tare", rest_frames(), {"--output", calibration_, "--hold", "csv:none.csv"}), {"none.csv"}));
  EXPECT_FALSE(std::filesystem::exists(calibration_));
}

TEST_F(RestCommand, MistakesOfACallAreNamed) {
  const std::string rest = rest_frames();
  ASSERT_EQ(run("tare", rest, {"--output", calibration_}).exit_code, 0);
  const auto refused = [&](std::vector<std::string> more, const std::vector<std::string>& words) {
    more.insert(more.end(), {"--calibration", calibration_});
    return is_refused(run("monitor", rest, more), words);
  };
  EXPECT_TRUE(refused({}, {"--network", "--rest"}));
  EXPECT_TRUE(refused({"--signal", "moved", "--alarm"}, {"--alarm", "tare --hold"}));
  EXPECT_TRUE(refused({"--signal", "moved", "--alarm", "0.8"}, {"--alarm", "below 0.5"}));
  EXPECT_TRUE(refused({"--rest", "--alarm", "0"}, {"--alarm", "above 0"}));
  EXPECT_TRUE(refused({"--rest", "--touch", "0"}, {"--touch", "above 0"}));
  EXPECT_TRUE(refused({"--rest", "--signal", "slip"}, {"--signal", "--network"}));
  EXPECT_TRUE(refused({"--rest", "--view"}, {"--view", "moved"}));
  EXPECT_TRUE(refused({"--rest", "--device", "cpu"}, {"--device", "--network"}));
  EXPECT_TRUE(is_refused(run("monitor", rest, {"--rest", "--touch", "0.01"}), {"no reading at rest", "tactel tare"}));
}

// A sphere is pressed for 0.5 s, rests for 1 s, is dragged for 2 s and then let go, twice. The drag alone raises the
// alarm, before all slides. The changes of the recorded frames say the same.
TEST_F(RestCommand, ASimulatedGripRaisesTheAlarmWhereItSlides) {
  const std::string grips =
      "simulate:" + source_file("examples/pad.toml") + "?rate=100&paced=0&time_constant=0&hold=1&repeat=2";
  const ChildResult said = run_tactel({"monitor", "--source", grips, "--signal", "moved", "--alarm", "0.1"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  const auto lines = lines_of(said.out);
  ASSERT_EQ(lines.size(), 801u);
  const std::string table = folder_ / "f.csv";
  ASSERT_EQ(run_tactel({"record", "--source", grips, "--output", recording_, "--frames", table}).exit_code, 0);
  std::vector<std::vector<double>> frames;
  std::istringstream text(text_of(table));
  std::string line;
  for (std::getline(text, line); std::getline(text, line);) {
    std::istringstream numbers(line);
    auto& frame = frames.emplace_back();
    for (std::string number; std::getline(numbers, number, ',');)
      if (frame.size() < 51) frame.push_back(number.empty() ? 0 : std::stod(number));
  }
  const auto mean = [&](std::size_t from, std::size_t channel) {
    double sum = 0;
    for (std::size_t i = from; i < from + 40; ++i) sum += frames[i][3 + channel] / 40;
    return sum;
  };
  for (const std::size_t pass : {0u, 400u}) {
    for (std::size_t i = pass; i < pass + 150; ++i) EXPECT_EQ(lines[i]["alarm"], false) << i;
    EXPECT_EQ(lines[pass + 40]["rest"], false);
    EXPECT_EQ(lines[pass + 149]["rest"], true);
    std::size_t begins = pass;
    while (begins < pass + 400 && lines[begins]["alarm"] == false) ++begins;
    ASSERT_LT(begins, pass + 400);
    EXPECT_LT(lines[begins]["true_slip_index"].get<double>(), 1);
    double change = 0, P = 0;
    for (std::size_t k = 0; k < 48; ++k) {
      change += std::pow(mean(pass + 355, k) - mean(pass + 105, k), 2);
      if (k < 16) P += mean(pass + 105, k) - 2048;
    }
    EXPECT_NEAR(lines[pass + 380]["moved"].get<double>(), std::sqrt(change) / std::abs(P), 0.02);
  }
}

// The network of the library has the hold's threshold from tare, judges the alarm, and is one to recall.
TEST_F(RestCommand, TheNetworkOfTheLibraryTakesTheThresholdOfAHold) {
  const std::string chain = "?rest=3&hold=1&time_constant=0&paced=0&gain_spread=0",
                    grip = "simulate:" + source_file("examples/pad.toml") + chain;
  std::string scene = text_of(source_file("examples/pad.toml"));
  const std::string far = "[0.06, 0.02]";
  ASSERT_NE(scene.find(far), std::string::npos);
  scene.replace(scene.find(far), far.size(), "[0.006, 0.002]");  // a tenth of the drag that slides
  EXPECT_TRUE(is_refused(run_tactel({"tare", "--source", grip, "--output", calibration_, "--network", "uskin-4x4"}),
                         {"--network", "--hold"}));
  const std::string hold = folder_ / "hold.rec";
  ASSERT_EQ(
      run_tactel({"record", "--source", "simulate:" + folder_.write("hold.toml", scene) + chain, "--output", hold})
          .exit_code,
      0);
  const ChildResult tared =
      run_tactel({"tare", "--source", grip, "--output", calibration_, "--hold", hold, "--network", "uskin-4x4"});
  ASSERT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_THAT(text_of(calibration_), HasSubstr("\nslid = 0.0"));
  const ChildResult said = run_tactel(
      {"monitor", "--source", grip, "--calibration", calibration_, "--network", "uskin-4x4", "--alarm", "--quiet"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  int begins = 0;
  bool on = false;
  for (const auto& line : lines_of(said.out)) {
    if (line["alarm"] == true && !on) {
      ++begins;
      EXPECT_GT(line["device_time"].get<double>(), 4.5);
    }
    on = line["alarm"];
    EXPECT_EQ(line["slid"].is_null(), line["rest"] == false || line["contact"] == false) << line;
  }
  EXPECT_EQ(begins, 1);
  const ChildResult recalled = run_tactel({"recall", "uskin-4x4", hold});
  EXPECT_EQ(recalled.exit_code, 0) << recalled.err;
}

// Lines of standard input end the rest, and it is found again.
TEST_F(RestCommand, ALineOfStandardInputSeeksRestAnew) {
  const ChildResult result = run_child({"/bin/sh", "-c",
                                        fmt::format("while sleep 0.3; do echo rest; done | {} monitor --rest --source "
                                                    "'simulate:{}?press=0.1&hold=1.2&drag=0&slip=0&time_constant=0'",
                                                    TACTEL_PROGRAM, source_file("examples/pad.toml"))});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  int lost = 0, found = 0;
  bool before = false;
  for (const auto& line : lines_of(result.out)) {
    if (line["contact"] != true) continue;
    lost += before && line["rest"] == false, found += !before && line["rest"] == true;
    before = line["rest"];
  }
  EXPECT_GE(lost, 1);
  EXPECT_GE(found, 2);
}

}  // namespace tactel::host::rest_command_test
