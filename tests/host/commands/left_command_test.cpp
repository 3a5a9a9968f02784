// SPDX-License-Identifier: Apache-2.0

// monitor --rest --alarm, tare --hold and tare --slide as a user runs them, on lines of two simple pads of springs.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "host/scenes/toml_table.h"
#include "tests/host/commands/live_command.h"

namespace tactel::host::left_command_test {

using ::testing::HasSubstr;

/// Two uSkin pads of springs with Coulomb's law, mu 0.6, under a face that presses unevenly: counts at 100 Hz.
class Pads {
 public:
  /// press: 0 to 1 of 5700 counts of a pad. load: of mu P, along y. tremor: of P, in pressure and load. turned: moves
  /// pressure along x, and twists.
  void add(double press, double load, double tremor = 0.004, double turned = 0) {
    const double sway = tremor * std::sin(0.5 * frame_), p = press * (1 + sway), q = load + 0.3 * sway;
    std::vector<double> counts;
    for (int pad = 0; pad < 2; ++pad) {
      std::vector<double> normal;
      for (int t = 0; t < 16; ++t) normal.push_back(p * (300 + (25 + 100 * turned) * (t % 4 - 1.5) + 12 * (t / 4)));
      const auto shear = [&](double way) {
        double sum = 0;
        for (const double n : normal) sum += std::min(way, 0.6 * n);
        return sum;
      };
      double low = 0, high = 1000;
      for (int i = 0; i < 40 && p > 0; ++i)
        (shear((low + high) / 2) < q * 0.6 * sum_of(normal) ? low : high) = (low + high) / 2;
      for (std::size_t t = 0; t < 16; ++t) {
        const double twist = 30 * turned * (static_cast<double>(t / 4) - 1.5), side = pad == 0 ? 1 : -1;
        for (const double number : {twist, side * std::min(low, 0.6 * normal[t]), normal[t]})
          counts.push_back(std::round(30000 + number + 2 * noise_(random_)));
      }
    }
    text_ += fmt::format("{:.2f},{}\n", 0.01 * frame_++, fmt::join(counts, ","));
  }
  void empty(int frames) {
    for (int i = 0; i < frames; ++i) add(0, 0);
  }
  /// Half a second that presses, a load of 0.2, and some time of hold.
  void grip(int frames, double tremor = 0.004) {
    for (int i = 0; i < 50; ++i) add(i / 50.0, 0);
    for (int i = 0; i < frames; ++i) add(1, std::min(0.2, 0.01 * i), tremor);
  }
  const std::string& text() const { return text_; }
  int frames() const { return frame_; }

 private:
  static double sum_of(const std::vector<double>& numbers) {
    double sum = 0;
    for (const double n : numbers) sum += n;
    return sum;
  }
  std::string text_ = "time," + [] {
    std::vector<std::string> names;
    for (int i = 0; i < 96; ++i) names.push_back(fmt::format("c{}", i));
    return fmt::format("{}\n", fmt::join(names, ","));
  }();
  std::mt19937 random_{11};
  std::normal_distribution<double> noise_;
  int frame_ = 0;
};

class LeftCommand : public LiveCommand {
 protected:
  ChildResult run(const std::string& command, const std::string& source, std::vector<std::string> more = {}) const {
    more.insert(more.end(), {"--profile", "uskin-4x4", "--profile", "uskin-4x4"});
    return run_tactel({command, "--source", source}, more);
  }
  std::string csv(const std::string& name, const Pads& pads) { return "csv:" + folder_.write(name, pads.text()); }
  ChildResult tare(std::vector<std::string> more = {}) {
    Pads empty;
    empty.empty(250);
    more.insert(more.end(), {"--output", calibration_, "--force"});
    return run("tare", csv("empty.csv", empty), more);
  }
  std::vector<nlohmann::json> monitor(const Pads& pads, std::vector<std::string> more = {"--rest", "--alarm"}) {
    more.insert(more.end(), {"--calibration", calibration_, "--quiet"});
    const ChildResult said = run("monitor", csv("use.csv", pads), more);
    EXPECT_EQ(said.exit_code, 0) << said.err;
    return lines_of(said.out);
  }
  /// Whether an alarm is on in one of some lines.
  static bool rings(const std::vector<nlohmann::json>& lines, std::size_t from, std::size_t to) {
    return std::any_of(lines.begin() + static_cast<std::ptrdiff_t>(from),
                       lines.begin() + static_cast<std::ptrdiff_t>(to),
                       [](const auto& line) { return line["alarm"] == true; });
  }
  const std::string calibration_ = folder_ / "c.toml";
};

// Touch-down, hold, a squeeze to 1.2 and an easing to a half, release: silent; "released" is said.
TEST_F(LeftCommand, IsTheDefaultOfRestAndSaysWhatItKnows) {
  ASSERT_EQ(tare().exit_code, 0);
  Pads use;
  use.empty(60), use.grip(200);
  for (int i = 0; i < 50; ++i) use.add(1 + 0.2 * std::sin(0.0628 * i), 0.2);
  for (int i = 0; i < 100; ++i) use.add(1 - 0.005 * i, 0.2);
  for (int i = 0; i < 15; ++i) use.add(0.5 - i / 30.0, 0.2);
  use.empty(40);
  const auto lines = monitor(use);
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(use.frames()));
  EXPECT_FALSE(rings(lines, 0, lines.size()));
  const auto& held = lines[300];
  EXPECT_EQ(held["rest"], true);
  EXPECT_EQ(held["cannot_tell"], false);
  EXPECT_FALSE(held.contains("why") || held.contains("released") || held.contains("index"));
  EXPECT_NEAR(held["calm"].get<double>(), 0.003, 0.0025) << "0.4 % of sine, 2 counts of noise";
  EXPECT_LT(held["left"].get<double>(), 0.5);
  EXPECT_EQ(held["pads"].size(), 2u);
  EXPECT_EQ(held["pads"][0].contains("left"), true);
  EXPECT_EQ(lines[70]["cannot_tell"], true);
  EXPECT_EQ(lines[70]["why"], "no rest");
  EXPECT_EQ(lines.back()["released"], true);
  EXPECT_EQ(lines.back()["cannot_tell"], false);
}

// A hold that was recorded, twice, lowers the threshold below what the slide of these stiff springs changes.
TEST_F(LeftCommand, HoldsAreLearnt) {
  Pads hold, use;
  hold.empty(60), hold.grip(250), hold.empty(50), hold.grip(150);
  const std::string recorded = csv("hold.csv", hold);
  const ChildResult tared = tare({"--hold", recorded, "--hold", recorded});
  ASSERT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_THAT(tared.err,
              ::testing::ContainsRegex("hold of 7\\.[0-9] s: the alarm of left begins at [0-9.]+, 2\\.[23]"));
  const TomlFile file(calibration_);
  TomlTable table(file, "hold");
  std::vector<double> covariance;
  double at = 0, seconds = 0, rate = 0, margin = 0;
  table.read("covariance", covariance, ""), table.read("at", at, ""), table.read("seconds", seconds, "");
  table.read("rate", rate, ""), table.read("margin", margin, "");
  table.finish();
  EXPECT_EQ(covariance.size(), 36u);
  EXPECT_GT(at, 1);
  EXPECT_NEAR(rate, 100, 1e-6);
  EXPECT_NEAR(margin, std::min(1.4 + 6.5 / seconds, 4.5), 1e-3);

  use.empty(60), use.grip(200);
  for (int i = 0; i < 100; ++i) use.add(1, 0.2 + 0.011 * i);
  const auto lines = monitor(use);
  EXPECT_FALSE(rings(lines, 0, 310));
  EXPECT_TRUE(rings(lines, 310, 410));
  const ChildResult without =
      run("monitor", csv("use.csv", use), {"--rest", "--alarm", "--touch", "0.001", "--calibration", calibration_});
  EXPECT_THAT(without.err, ::testing::Not(HasSubstr("no hold was recorded")));
  ASSERT_EQ(tare().exit_code, 0);
  EXPECT_THAT(run("monitor", csv("use.csv", use), {"--rest", "--alarm", "--calibration", calibration_}).err,
              HasSubstr("no hold was recorded"));
}

// An object that turns is no hold, and nothing is written.
TEST_F(LeftCommand, AHoldThatMovesIsRefused) {
  Pads moves;
  moves.empty(60), moves.grip(200);
  for (int i = 0; i < 60; ++i) moves.add(1, 0.2, 0.004, i / 60.0);
  EXPECT_TRUE(is_refused(tare({"--hold", csv("moves.csv", moves)}), {"moves.csv", "it moves at"}, 3));
  EXPECT_FALSE(std::filesystem::exists(calibration_));
}

// mu is 0.6: the index is the load's share of it, and 1 where all slides.
TEST_F(LeftCommand, ASlideIsRemembered) {
  Pads slide, use;
  slide.empty(60), slide.grip(120);
  for (int i = 0; i < 160; ++i) slide.add(1, std::min(1.2, 0.2 + 0.02 * i));
  const ChildResult tared = tare({"--slide", csv("slide.csv", slide)});
  ASSERT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_THAT(tared.err, HasSubstr("it slides at Q / P = 0."));
  EXPECT_THAT(text_of(calibration_),
              ::testing::ContainsRegex("\\[slide\\]\nfriction = \\[0\\.(59|60)[0-9]*, 0\\.(59|60)"));
  use.empty(60), use.grip(200);
  for (int i = 0; i < 100; ++i) use.add(1, 0.2 + 0.01 * i);
  const auto lines = monitor(use);
  for (const std::size_t i : {200u, 300u, 350u, 409u}) {
    const double load = i < 310 ? 0.2 : std::min(1.0, 0.2 + 0.01 * static_cast<double>(i - 310));
    EXPECT_NEAR(lines[i]["index"].get<double>(), load, 0.03) << i;
  }
  Pads holds;
  holds.empty(60), holds.grip(200);
  for (int i = 0; i < 3; ++i) holds.add(1, 0.2);
  Pads nothing;
  nothing.empty(100);
  EXPECT_TRUE(is_refused(tare({"--slide", csv("nothing.csv", nothing)}), {"nothing.csv", "nothing slides"}, 3));
}

// A field of a pipe that is no number: lines go on, say so, and the page's reasons are those of the alarm.
TEST_F(LeftCommand, AFieldThatIsNoNumberCannotTell) {
  ASSERT_EQ(tare().exit_code, 0);
  for (const std::string word : {"nan", "null", "", "x"}) {
    Pads use;
    use.empty(60), use.grip(300);
    std::istringstream all(use.text());
    std::string text, line;
    for (int i = -1; std::getline(all, line); ++i) {
      if (i >= 200) line.replace(line.rfind(','), std::string::npos, "," + word);
      text += line + "\n";
    }
    const ChildResult said =
        run_child({"/bin/sh", "-c",
                   fmt::format("cat {} | {} monitor --source csv:- --profile uskin-4x4 --profile uskin-4x4 --late 100 "
                               "--calibration {} --rest --alarm --quiet",
                               folder_.write("dead.csv", text), TACTEL_PROGRAM, calibration_)});
    ASSERT_EQ(said.exit_code, 0) << said.err;
    const auto lines = lines_of(said.out);
    ASSERT_EQ(lines.size(), static_cast<std::size_t>(use.frames())) << word;
    for (std::size_t i = 190; i < lines.size(); ++i) {
      EXPECT_EQ(lines[i]["cannot_tell"], i >= 200) << i;
      EXPECT_EQ(lines[i].value("why", ""), i >= 200 ? "not a number" : "") << i;
      EXPECT_EQ(lines[i]["alarm"], false) << i;
    }
  }
}

}  // namespace tactel::host::left_command_test
