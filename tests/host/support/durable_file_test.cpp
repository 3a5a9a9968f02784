// SPDX-License-Identifier: Apache-2.0

// Files that appear whole or not at all, and the small helpers beside them.
#include "host/support/durable_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/support/nearest_word.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::durable_file_test {

TEST(DurableFile, ReplacesAndLeavesNothingElse) {
  const ScratchFolder folder;
  write_file("--json", folder / "a", "old");
  write_file("--json", folder / "a", "new");
  EXPECT_EQ(text_of(folder / "a"), "new");
  EXPECT_EQ(folder.files(), 1u);
}

TEST(DurableFile, FollowsLinks) {
  const ScratchFolder folder;
  folder.write("real", "old");
  std::filesystem::create_symlink("real", folder / "link");
  write_file("--json", folder / "link", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(text_of(folder / "real"), "new");
}

TEST(DurableFile, WritesStraightToWhatIsNoFile) { EXPECT_NO_THROW(write_file("--json", "/dev/null", "x")); }

TEST(DurableFile, SaysWhyNot) {
  const ScratchFolder folder;
  folder.write("file", "");
  EXPECT_THAT([&] { check_writable("--json", folder / "no" / "a"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("No such file or directory")));
  EXPECT_THAT([&] { check_writable("--json", folder / "file" / "a"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("Not a directory")));
  EXPECT_THAT([&] { check_writable("--json", folder / ""); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("it names a folder")));
  const std::string cut = (folder / "new").string() + std::string("\0x", 2);
  EXPECT_THAT([&] { write_file("--json", cut, "x"); }, testing::Throws<ConfigError>());
  EXPECT_FALSE(std::filesystem::exists(folder / "new"));
  EXPECT_THAT([] { write_file("--json", "/dev/full", "x"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("No space left on device")));
}

std::vector<std::string> names_in(const ScratchFolder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
    names.push_back(entry.path().filename().string());
  return names;
}

TEST(DurableFile, IsThereWhenCommittedAndNotBefore) {
  const ScratchFolder folder;
  {
    DurableFile file("--output", folder / "a");
    file.write("half");
    EXPECT_FALSE(std::filesystem::exists(folder / "a"));
  }
  EXPECT_THAT(names_in(folder), testing::IsEmpty());
  DurableFile file("--output", folder / "a");
  file.write("one, ");
  file.write("two");
  file.commit();
  EXPECT_EQ(text_of(folder / "a"), "one, two");
  EXPECT_THAT(names_in(folder), testing::ElementsAre("a"));
}

// Names that the next temporaries will have, as links to a file of somebody else.
TEST(DurableFile, NeverWritesThroughALinkInPlaceOfItsTemporary) {
  const ScratchFolder folder;
  folder.write("victim", "untouched");
  for (int count = 0; count < 200; ++count)
    std::filesystem::create_symlink("victim", folder / (".a." + running_kernel() + "." + std::to_string(::getpid()) +
                                                        "." + std::to_string(count) + ".tactel-part"));
  write_file("--output", folder / "a", "new");
  EXPECT_EQ(text_of(folder / "victim"), "untouched");
  EXPECT_EQ(text_of(folder / "a"), "new");
}

// flock tells a temporary in use from one that a killed process left.
TEST(DurableFile, RemovesWhatKilledProcessesLeftAndNothingElse) {
  const ScratchFolder folder;
  const std::string left = ".set.h5." + running_kernel() + ".4711.0.tactel-part",
                    used_name = ".used." + running_kernel() + ".4711.3.tactel-part";
  for (const std::string& name : {left, used_name, std::string(".a.b.tactel-part"), std::string("notes.1.2.part")})
    folder.write(name, "x");
  const int used = ::open((folder / used_name).c_str(), O_RDWR);
  ASSERT_EQ(::flock(used, LOCK_EX), 0);
  remove_leftovers(folder / "");
  EXPECT_THAT(names_in(folder), testing::UnorderedElementsAre(used_name, ".a.b.tactel-part", "notes.1.2.part"));
  ::close(used);
  write_file("--output", folder / "a", "new");  // the first writing into a folder looks for leftovers
  EXPECT_THAT(names_in(folder), testing::UnorderedElementsAre("a", ".a.b.tactel-part", "notes.1.2.part"));
}

// On some network file systems a lock is seen by its own host alone: a file of another one has to be old.
TEST(DurableFile, LeavesTheTemporariesOfOtherHosts) {
  const ScratchFolder folder;
  const std::string young = ".set.h5.0123456789abcdef.4711.0.tactel-part",
                    old = ".set.h5.0123456789abcdef.4711.1.tactel-part";
  for (const std::string& name : {young, old}) folder.write(name, "x");
  const auto now = std::filesystem::file_time_type::clock::now();
  std::filesystem::last_write_time(folder / young, now - std::chrono::hours(23));
  std::filesystem::last_write_time(folder / old, now - std::chrono::hours(25));
  remove_leftovers(folder / "");
  EXPECT_THAT(names_in(folder), testing::ElementsAre(young));
}

TEST(DurableFile, MakesFoldersAndRefusesFilesInTheirPlace) {
  const ScratchFolder folder;
  make_folder("--output", folder / "a/b/c");
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b/c"));
  make_folder("--output", folder / "a/b/c");
  folder.write("file", "");
  EXPECT_THAT([&] { make_folder("--output", folder / "file/d"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("Not a directory")));
  EXPECT_THAT([&] { make_folder("--output", folder / "file"); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("Not a directory")));
}

TEST(FileLock, IsHeldByOneAndFreeAfterwards) {
  const ScratchFolder folder;
  for (const bool of_file : {false, true}) {
    const auto take = [&] {
      return of_file ? FileLock::of_file("--output", folder / "lock", "free")
                     : FileLock::of_folder("--output", folder / "", "free");
    };
    {
      const FileLock held = take();
      EXPECT_TRUE(held.held());
      EXPECT_THROW(take(), ConfigError);
    }
    EXPECT_TRUE(take().held());
  }
  EXPECT_THROW(FileLock::of_folder("--output", folder / "none", "free"), ConfigError);
}

TEST(NearestWord, TakesTheNearestOrNone) {
  const std::vector<std::string> words{"length", "thickness", "tactels", "rows"};
  EXPECT_EQ(did_you_mean("lenght", words), "; did you mean length?");  // two letters swapped
  EXPECT_EQ(did_you_mean("row", words), "; did you mean rows?");
  EXPECT_EQ(did_you_mean("thicknes", words), "; did you mean thickness?");
  EXPECT_EQ(did_you_mean("thick", words), "; did you mean thickness?") << "its beginning";
  EXPECT_EQ(did_you_mean("LENGTH", words), "; did you mean length?");
  EXPECT_EQ(did_you_mean("gravity", words), "");
  EXPECT_EQ(did_you_mean("ta", words), "") << "two letters are a beginning of much";
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

}  // namespace tactel::host::durable_file_test
