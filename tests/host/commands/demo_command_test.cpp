// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

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
