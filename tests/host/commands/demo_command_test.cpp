// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "tests/host/commands/live_command.h"

namespace tactel::host::demo_command_test {

using testing::HasSubstr;

TEST(DemoSlow, ShowsEachCommandAndLeavesPagesAndANetwork) {
  const ScratchFolder folder;
  const std::string output = (folder / "demo").string();
  const ChildResult result = run_tactel({"demo", "--output", output});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* command : {"$ tactel solve ", "$ tactel generate ", "$ tactel train ", "$ tactel recall ",
                              "$ tactel monitor --source 'simulate:"})
    EXPECT_THAT(result.out, HasSubstr(command));
  EXPECT_THAT(result.out, HasSubstr("\"slip_index\": "));
  std::set<std::string> reasons;
  std::istringstream lines(result.out);
  for (std::string line, before; std::getline(lines, line); before = line) {
    if (!line.starts_with("$ tactel ")) continue;
    EXPECT_THAT(before, testing::MatchesRegex("# [A-Z].{30,75}[.?]")) << line;
    reasons.insert(before);
  }
  EXPECT_EQ(reasons.size(), 6u) << "a reason of its own before each command";
  for (const char* page : {"contact.html", "networks.html"})
    EXPECT_THAT(text_of(folder / "demo" / page), testing::StartsWith("<!doctype html>")) << page;
  EXPECT_TRUE(std::filesystem::exists(folder / "demo/networks/42-42-21-1_noise0.001_seed1.onnx"));

  EXPECT_TRUE(is_refused(run_tactel({"demo", "--output", output}), {"--force"}));

  // Other gains and noise of the sensor: S within 0.06 of the true one on average, as the network's mean error of 0.054
  // on such contacts allows, and no alarm at touch-down. A network that learnt neither gains nor decay is off by 0.11.
  double sum = 0;
  for (const char* rate : {"100", "1000"})
    for (int seed = 1; seed <= 5; ++seed) {
      const ChildResult live =
          run_tactel({"monitor", "--source",
                      "simulate:" + output + "/contact.toml?paced=0&rate=" + rate + "&seed=" + std::to_string(seed),
                      "--network", output + "/networks/42-42-21-1_noise0.001_seed1.onnx", "--alarm", "0.8", "--quiet"});
      ASSERT_EQ(live.exit_code, 0) << live.err;
      double errors = 0, answers = 0;
      bool alarm = false;
      for (const nlohmann::json& line : lines_of(live.out)) {
        alarm = line["alarm"];
        if (line["slip_index"].is_null()) continue;
        const double truth = line["true_slip_index"], error = std::abs(line["slip_index"].get<double>() - truth);
        errors += error, ++answers;
        if (truth < 0.4) {
          EXPECT_FALSE(alarm) << rate << " Hz, seed " << seed << ": " << line;
        }
      }
      EXPECT_TRUE(alarm) << "it slides at the end";
      EXPECT_NEAR(lines_of(live.err).back()["slip_index_error"].get<double>(), errors / answers, 6e-4) << "3 digits";
      sum += errors / answers / 10;
    }
  EXPECT_LT(sum, 0.06);
}

TEST(Demo, EndsWithTheCodeOfTheCommandThatFails) {
  const ScratchFolder folder;
  EXPECT_EQ(run_tactel({"demo", "--output", (folder / "demo").string(), "--device", "no such device"}).exit_code, 2);
}

}  // namespace tactel::host::demo_command_test
