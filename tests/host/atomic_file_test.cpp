// Files that appear whole or not at all, and the small helpers beside them.
#include "host/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/errors.h"
#include "host/json_text.h"
#include "host/nearest_word.h"
#include "tests/host/run_tactel.h"

namespace tactel::host {
namespace {

TEST(AtomicFile, ReplacesAndLeavesNothingElse) {
  const ScratchFolder folder;
  write_file("--json", folder / "a", "old");
  write_file("--json", folder / "a", "new");
  EXPECT_EQ(text_of(folder / "a"), "new");
  EXPECT_EQ(folder.files(), 1u);
}

TEST(AtomicFile, FollowsLinks) {
  const ScratchFolder folder;
  folder.write("real", "old");
  std::filesystem::create_symlink("real", folder / "link");
  write_file("--json", folder / "link", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(text_of(folder / "real"), "new");
}

TEST(AtomicFile, WritesStraightToWhatIsNoFile) { EXPECT_NO_THROW(write_file("--json", "/dev/null", "x")); }

TEST(AtomicFile, SaysWhyNot) {
  const ScratchFolder folder;
  folder.write("file", "");
  EXPECT_THAT([&] { check_writable("--json", folder / "no" / "a"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("No such file or directory")));
  EXPECT_THAT([&] { check_writable("--json", folder / "file" / "a"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("Not a directory")));
  EXPECT_THAT([&] { check_writable("--json", folder / ""); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("it names a folder")));
  EXPECT_THAT([] { write_file("--json", "/dev/full", "x"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("No space left on device")));
}

TEST(NearestWord, TakesTheNearestOrNone) {
  const std::vector<std::string> words{"length", "thickness", "tactels", "rows"};
  EXPECT_EQ(nearest_word("lenght", words), "length");  // two letters swapped
  EXPECT_EQ(nearest_word("row", words), "rows");
  EXPECT_EQ(nearest_word("thicknes", words), "thickness");
  EXPECT_EQ(nearest_word("gravity", words), "");
  EXPECT_EQ(listed(words), "length, thickness, tactels, rows");
}

TEST(JsonText, ReadsBackAsItWas) {
  const nlohmann::ordered_json value = {{"z", {0.1, 1e-300, -0.0}},
                                        {"a", nullptr},
                                        {"nested", {{{"k", "\"q\""}}, {{"k", nlohmann::ordered_json::array()}}}}};
  const std::string text = json_text(value);
  EXPECT_EQ(nlohmann::ordered_json::parse(text), value);
  EXPECT_THAT(text, testing::HasSubstr("\"z\": [0.1, 1e-300, -0.0]"));
}

TEST(ChildProcess, GivesBothStreamsAndTheExitCode) {
  const ChildResult result =
      run_child({"sh", "-c", "yes | head -c 200000; echo oops >&2; exit 3"});  // more than a pipe holds
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.out.size(), 200000u);
  EXPECT_EQ(result.err, "oops\n");
  EXPECT_EQ(run_child({"no-such-program-anywhere"}).exit_code, 127);
  EXPECT_EQ(run_child({"sh", "-c", "kill -TERM $$"}).exit_code, 128 + 15);
}

}  // namespace
}  // namespace tactel::host
