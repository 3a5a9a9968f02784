// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <set>

#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

using testing::HasSubstr;

TEST(Demo, ShowsEachCommandAndLeavesPagesAndANetwork) {
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
}

TEST(Demo, EndsWithTheCodeOfTheCommandThatFails) {
  const ScratchFolder folder;
  EXPECT_EQ(run_tactel({"demo", "--output", (folder / "demo").string(), "--device", "no such device"}).exit_code, 2);
}

}  // namespace
}  // namespace tactel::host
