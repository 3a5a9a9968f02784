// SPDX-License-Identifier: Apache-2.0

// The bound as a user meets it: train, calibrate, recall, monitor.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>

#include "host/sets/contact_set.h"
#include "tests/host/commands/live_command.h"
#include "tests/host/commands/small_sweep.h"

namespace tactel::host::bound_command_test {

using nlohmann::json;
using ::testing::HasSubstr;

/// A set of 300 drags until sliding and a network with a bound that learnt a little from it, made once.
class BoundCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    for (const auto& [name, seed] : {std::pair{"learn", 1}, {"other", 2}}) {
      const SmallSweep sweep{.contacts = 300,
                             .sweep = "seed = " + std::to_string(seed) + "\n",
                             .friction = "{ uniform = [0.2, 0.8] }",
                             .drag = "tangential_step = 0.02"};
      std::ofstream(*folder_ / (std::string(name) + ".toml")) << sweep.text();
      ASSERT_EQ(run_tactel({"generate", file(name, ".toml"), "--output", file(name, ".h5"), "--quiet"}).exit_code, 0);
    }
    ASSERT_EQ(train("net", {}).exit_code, 0);
  }
  static ChildResult train(const std::string& output, const std::vector<std::string>& more) {
    const std::string call = "train " + file("learn", ".h5") +
                             " --network 10-12-1 --schedule batch --bound --scaling " +
                             "frame --epochs 20 --learning-rate 0.01 --quiet --output " + file(output);
    return run_tactel(words(call), more);
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string file(const std::string& name, const std::string& extension = "") {
    return (*folder_ / (name + extension)).string();
  }
  static std::string network() { return file("net/10-12-3_noise0_seed1.onnx"); }
  static std::string calibrated() {
    std::string output = file("calibrated.onnx");
    const ChildResult result = run_tactel({"calibrate", "bound", network(), file("other", ".h5"), "--output", output});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("bound of 95 %, calibrated on"));
    return output;
  }
  static std::unique_ptr<ScratchFolder> folder_;
};
std::unique_ptr<ScratchFolder> BoundCommand::folder_;

// By construction the corrections cover 95 % of the rows that they come from, but for classes of few rows, which take
// those of a larger group. The file tells its origin.
TEST_F(BoundCommand, CalibratesANetworkAndSaysOnWhat) {
  const std::string bare = text_of(network()), output = calibrated();
  EXPECT_EQ(text_of(network()), bare);
  const ChildResult before = run_tactel({"recall", network(), file("other", ".h5")});
  EXPECT_THAT(before.out, HasSubstr("bound not calibrated"));
  const ChildResult after = run_tactel({"recall", output, file("other", ".h5"), "--json", "-"});
  ASSERT_EQ(after.exit_code, 0) << after.err;
  const json report = json::parse(after.out)["networks"][0];
  EXPECT_EQ(report["calibration"]["calibrated"], true);
  EXPECT_EQ(report["calibration"]["level"], 0.95);
  EXPECT_EQ(report["calibration"]["seed"], 2);
  EXPECT_EQ(report["calibration"]["set"], file("other", ".h5"));
  EXPECT_GT(report["calibration"]["rows"], 1000);
  const json& bound = report["bound"];
  EXPECT_GE(bound["coverage"], 0.945);
  EXPECT_GE(bound["interval_coverage"], 0.945);
  EXPECT_LE(bound["coverage"], 1.0);
  EXPECT_GT(bound["width"], 0.0);
  EXPECT_LE(bound["unlike"], 0.0011);
  EXPECT_EQ(bound["by_slip_index"].size(), 10u);
  EXPECT_EQ(bound["answered"][2]["share"], 0.95);
  EXPECT_LE(bound["answered"][2]["width"], bound["answered"][0]["width"]);
}

// What a user counts by S <= slip_upper is what recall prints. A bound ends at exactly 1, where drags slide. recall
// grants the rounding of 1e-6, which decides for few rows that do not slide.
TEST_F(BoundCommand, CoversTheRowsThatAUserCounts) {
  const ChildResult result =
      run_tactel({"recall", calibrated(), file("learn", ".h5"), "--json", "-", "--rows", file("counted.csv")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(text_of(file("counted.csv")));
  std::string line;
  std::getline(lines, line);
  double rows = 0, covered = 0, sliding = 0;
  while (std::getline(lines, line)) {
    std::istringstream numbers(line);
    std::string row, truth, answer, upper;
    std::getline(std::getline(std::getline(std::getline(numbers, row, ','), truth, ','), answer, ','), upper, ',');
    EXPECT_LE(std::stof(truth), 1.0f);
    rows += 1, covered += std::stof(truth) <= std::stof(upper), sliding += std::stof(truth) == 1.0f;
  }
  EXPECT_GT(sliding, 200);
  const json report = json::parse(result.out);
  EXPECT_EQ(report["rows"], rows);
  EXPECT_NEAR(report["networks"][0]["bound"]["coverage"], covered / rows, 5e-4);
}

TEST_F(BoundCommand, TrainCalibratesAtItsEnd) {
  ASSERT_EQ(train("bound_set", {"--bound-set", file("other", ".h5")}).exit_code, 0);
  EXPECT_EQ(text_of(file("bound_set/10-12-3_noise0_seed1.onnx")), text_of(calibrated()));
  EXPECT_TRUE(is_refused(train("never", {"--bound-set", file("never", ".h5")}), {}));
  EXPECT_FALSE(std::filesystem::exists(file("never"))) << "it is asked for before the training";
}

TEST_F(BoundCommand, RenewsTheBoundInPlace) {
  const std::string copy = file("copy.onnx");
  std::filesystem::copy_file(network(), copy);
  const ChildResult result =
      run_tactel({"calibrate", "bound", copy, file("other", ".h5"), "--level", "0.8", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(run_tactel({"recall", copy, file("other", ".h5")}).out, HasSubstr("bound of 80 %"));
}

TEST_F(BoundCommand, SaysWhatCannotBeCalibrated) {
  const std::string plain = file("plain");
  ASSERT_EQ(run_tactel({"train", file("learn", ".h5"), "--network", "10-3-1", "--schedule", "batch", "--epochs", "1",
                        "--output", plain, "--quiet"})
                .exit_code,
            0);
  ChildResult result = run_tactel({"calibrate", "bound", plain + "/10-3-1_noise0_seed1.onnx", file("other", ".h5")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("a network with a bound"));
  result = run_tactel({"calibrate", "bound", network(), network()});
  EXPECT_EQ(result.exit_code, 2);
  result = run_tactel({"calibrate", "bound", network(), file("other", ".h5"), "--output", file("no/such/place.onnx")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--output"));
  result = run_tactel(
      {"calibrate", "bound", network(), file("other", ".h5"), "--output", file("never.onnx"), "--level", "0.9998"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("at least 4999"));
  EXPECT_FALSE(std::filesystem::exists(file("never.onnx")));
  result = run_tactel({"train", file("learn", ".h5"), "--bound", "--network", "10-3-1", "--output", file("online")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--schedule batch"));
}

// The learning set itself is no fair judge.
TEST_F(BoundCommand, WarnsOfTheLearningSet) {
  const ChildResult result =
      run_tactel({"calibrate", "bound", network(), file("learn", ".h5"), "--output", file("same.onnx")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("the network learnt from this set"));
}

TEST_F(BoundCommand, RecallJudgesDecisions) {
  const std::string csv = file("curves.csv"), page = file("page.html");
  const ChildResult result =
      run_tactel({"recall", calibrated(), file("other", ".h5"), "--decision", "--decision-csv", csv, "--html", page,
                  "--json", file("decision.json"), "--rows", file("rows.csv")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("alarm on"));
  const json decision = json::parse(text_of(file("decision.json")))["networks"][0]["decision"];
  ASSERT_EQ(decision["curves"].size(), 4u);  // by bound and by S, of all and of the only indenter
  EXPECT_EQ(decision["curves"][0]["signal"], "slip_upper");
  EXPECT_EQ(decision["curves"][2]["signal"], "slip_index");
  const json& points = decision["curves"][0]["thresholds"];
  EXPECT_EQ(points.size(), 35u);
  for (std::size_t i = 1; i < points.size(); ++i)  // a higher threshold detects no more
    EXPECT_LE(points[i]["detected"], points[i - 1]["detected"]);
  EXPECT_GT(points[0]["detected"], 0);
  const std::string curves = text_of(csv);
  EXPECT_EQ(std::ranges::count(curves, '\n'), 1 + 4 * 35);
  EXPECT_THAT(text_of(page), HasSubstr("Decision"));
  EXPECT_THAT(text_of(page), HasSubstr("slip_upper"));
  EXPECT_THAT(text_of(file("rows.csv")), HasSubstr("slip_upper,"));
  EXPECT_TRUE(decision["widest"].is_null());
  const ChildResult wide = run_tactel(
      {"recall", calibrated(), file("other", ".h5"), "--widest", "0", "--decision", "--json", file("w.json")});
  ASSERT_EQ(wide.exit_code, 0) << wide.err;
  EXPECT_THAT(wide.out, HasSubstr("cannot tell"));
  const json first = json::parse(text_of(file("w.json")))["networks"][0]["decision"]["curves"][0]["thresholds"][0];
  EXPECT_EQ(first["detected"], 0);
  EXPECT_EQ(first["told"], points[0]["detected"]);
  EXPECT_GT(first["cannot_tell_share"], 0);
}

// Contacts of another friction: the 95 % are told not to hold there, with both ranges of friction.
TEST_F(BoundCommand, SaysWhereItDoesNotHold) {
  const SmallSweep slippery{.contacts = 100,
                            .sweep = "seed = 3\n",
                            .friction = "{ uniform = [0.05, 0.1] }",
                            .drag = "tangential_step = 0.02"};
  std::ofstream(file("slippery", ".toml")) << slippery.text();
  ASSERT_EQ(
      run_tactel({"generate", file("slippery", ".toml"), "--output", file("slippery", ".h5"), "--quiet"}).exit_code, 0);
  const std::string network = calibrated(), set = file("slippery", ".h5");
  EXPECT_EQ(json::parse(run_tactel({"recall", network, set, "--json", "-"}).out)["networks"][0]["bound"]["holds"],
            false);
  EXPECT_THAT(run_tactel({"recall", network, set}).out,
              ::testing::ContainsRegex("the bound does not hold here: S of [0-9.]+ % of the rows is below slip_upper, "
                                       "where 95 % is stated; learnt at friction 0.2[0-9]* to 0.[78][0-9]*, here it is "
                                       "0.05[0-9]* to 0.[01][0-9]*\n"));
  EXPECT_EQ(
      json::parse(
          run_tactel({"recall", network, file("other", ".h5"), "--json", "-"}).out)["networks"][0]["bound"]["holds"],
      true);
  const std::string with = run_tactel({"recall", network, file("other", ".h5")}).out;
  EXPECT_THAT(with, ::testing::Not(HasSubstr("does not hold")));
  // No floor is printed, but what measures one; the option that left it out stays.
  EXPECT_THAT(with, HasSubstr("python -m tactel.floor SWEEP.toml"));
  EXPECT_EQ(run_tactel({"recall", network, file("other", ".h5"), "--no-floor"}).out, with);
}

// Rows of the set as lines of numbers: as they are, with all shears turned round, which nobody learnt, and in kPa.
TEST_F(BoundCommand, MonitorSaysWhereItCannotTell) {
  const ContactSet set = read_contact_set(file("other", ".h5"));
  const std::string profile = file("line", ".toml"), network = calibrated();
  std::ofstream(profile) << "[format]\nkind = \"csv\"\nchannels = 10\n[channels]\nnormal = [0, 1, 2, 3, 4]\n"
                            "shear = [5, 6, 7, 8, 9]\n[calibration]\noffset = 0\ngain = 1\nnoise = 1e-4\n";
  const auto played = [&](float normal, float shear, const std::vector<std::string>& more) {
    std::ofstream out(file("played", ".csv"));
    for (std::size_t row = 0; row < 400; ++row)
      for (int k = 0; k < 10; ++k)
        out << set.frames[row * 10 + static_cast<std::size_t>(k)] * (k < 5 ? normal : shear) << (k < 9 ? "," : "\n");
    out.close();
    return run_tactel(words("monitor --source csv:" + file("played", ".csv") + " --profile " + profile + " --network " +
                            network + " --alarm 0.8"),
                      more);
  };
  const auto count = [](const ChildResult& result, const char* key) {
    return std::ranges::count_if(lines_of(result.out), [&](const json& line) { return line[key] == true; });
  };
  const ChildResult turned = played(1, -1, {}), ignored = played(1, -1, {"--unlike", "ignore"}),
                    kpa = played(1e3f, 1e3f, {});
  ASSERT_EQ(turned.exit_code, 0) << turned.err;
  EXPECT_GT(count(turned, "unlike"), 40);
  for (const json& line : lines_of(turned.out)) {
    if (line["contact"] == false) continue;
    EXPECT_EQ(line["cannot_tell"], line["unlike"]) << line;
    if (line["unlike"] == true) {
      EXPECT_EQ(line["alarm"], true) << line;
    }
  }
  EXPECT_EQ(count(ignored, "unlike"), count(turned, "unlike"));
  EXPECT_LT(count(ignored, "alarm"), count(turned, "alarm"));
  for (const ChildResult* one : {&turned, &ignored}) {
    const auto first = one->err.find("which cannot tell its S");
    ASSERT_NE(first, std::string::npos) << one->err;
    EXPECT_EQ(one->err.find("which cannot tell its S", first + 1), std::string::npos) << "said once";
  }
  EXPECT_THAT(turned.err, HasSubstr("learnt friction 0.2"));
  EXPECT_THAT(turned.err, ::testing::Not(HasSubstr("10 times the largest")));
  EXPECT_THAT(kpa.err, HasSubstr("above 10 times the largest that the network learnt"));
}

using BoundCommandNightly = BoundCommand;
TEST_F(BoundCommandNightly, MonitorPrintsBoundAndAlarm) {
  const std::string source = "simulate:" + file("press.toml") + "?rate=100";
  std::ofstream(file("press.toml"))
      << "[sensor]\ncolumns = 11\nrows = 4\ntactels = 5\n[indenter]\nshape = \"parabola\"\n"
         "radius = 10\n[contact]\nfriction = 0.5\n[load]\nindentation = 0.15\n"
         "tangential_step = 0.02\n";
  const std::string file_name = calibrated();
  // A busy machine drops no frame as late.
  const ChildResult result =
      run_tactel({"monitor", "--source", source, "--network", file_name, "--late", "100", "--alarm", "0.7"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_GT(lines.size(), 20u);
  bool before = false;
  int changes = 0;
  for (const json& line : lines) {
    ASSERT_TRUE(line.contains("slip_upper") && line.contains("unlike") && line.contains("alarm")) << line;
    if (line["slip_upper"].is_null()) continue;
    EXPECT_GE(line["slip_upper"], line["slip_index"]);
    const double upper = line["slip_upper"];
    const bool alarm = line["alarm"];
    if (upper >= 0.7 || upper < 0.65) {
      EXPECT_EQ(alarm, upper >= 0.7 || line["unlike"]) << line;
    }
    EXPECT_EQ(line["cannot_tell"], line["unlike"]) << line;
    changes += alarm != before;
    before = alarm;
  }
  EXPECT_GT(changes, 0);
  // Events are printed, whatever --every says; without --alarm the lines have no such key.
  const auto events = lines_of(run_tactel({"monitor", "--source", source, "--network", file_name, "--late", "100",
                                           "--alarm", "0.7", "--every", "1000000"})
                                   .out);
  EXPECT_GT(events.size(), 1u);
  EXPECT_LT(events.size(), lines.size());
  for (std::size_t i = 1; i < events.size(); ++i) EXPECT_NE(events[i]["alarm"], events[i - 1]["alarm"]);
  // No interval is narrower than 0: what would be an alarm cannot tell.
  const auto wide = lines_of(run_tactel({"monitor", "--source", source, "--network", file_name, "--late", "100",
                                         "--alarm", "0.7", "--unlike", "ignore", "--widest", "0"})
                                 .out);
  ASSERT_EQ(wide.size(), lines.size());
  for (const json& line : wide) {
    EXPECT_EQ(line["alarm"], false);
    EXPECT_EQ(line["cannot_tell"], !line["slip_upper"].is_null() && (line["slip_upper"] >= 0.7 || line["unlike"]))
        << line;
  }
  const ChildResult quiet = run_tactel({"monitor", "--source", source, "--network", network()});
  EXPECT_FALSE(lines_of(quiet.out)[0].contains("alarm"));
  EXPECT_THAT(quiet.err, HasSubstr("not calibrated"));
}

}  // namespace tactel::host::bound_command_test
