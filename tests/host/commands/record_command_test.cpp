// SPDX-License-Identifier: Apache-2.0

// tactel record as a user runs it, on a simulated sensor.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "hw/recording.h"
#include "tests/host/commands/live_command.h"

namespace tactel::host::record_command_test {

using ::testing::HasSubstr;

class Record : public LiveCommand {
 protected:
  ChildResult record(std::vector<std::string> more, const std::string& source = simulation) const {
    return run_tactel({"record", "--source", source, "--quiet"}, more);
  }
  ChildResult replay() const {
    return run_tactel({"monitor", "--source", "replay:" + recording_, "--network", network_});
  }
};

TEST_F(Record, AFullDiskIsAnErrorAndTheRecordingStaysWhole) {
  EXPECT_TRUE(is_refused(record({"--output", recording_, "--frames", "/dev/full"}), {"/dev/full"}));
  const ChildResult kept = replay();
  EXPECT_EQ(kept.exit_code, 0);
  EXPECT_EQ(lines_of(kept.err).back()["cut_short"], false);
  EXPECT_TRUE(is_refused(record({"--output", "/dev/full"}), {"No space left"}));
}

TEST_F(Record, WritesOverNothingUnasked) {
  const std::string other = folder_.write("thesis.csv", "precious");
  for (const char* option : {"--output", "--frames"}) {
    const std::string output = option == std::string("--output") ? other : recording_;
    std::vector<std::string> arguments{"--output", output};
    if (output != other) arguments.insert(arguments.end(), {"--frames", other});
    EXPECT_TRUE(is_refused(record(arguments), {"--force"}));
    EXPECT_EQ(text_of(other), "precious");
    EXPECT_FALSE(std::filesystem::exists(recording_));
  }
  EXPECT_EQ(record({"--output", other, "--force"}).exit_code, 0);
  EXPECT_GT(text_of(other).size(), 8u);
  EXPECT_EQ(record({"--output", recording_, "--frames", recording_, "--force"}).exit_code, 2) << "two into one file";
}

TEST_F(Record, NeverWritesOverWhatItReplays) {
  ASSERT_EQ(record({"--output", recording_}).exit_code, 0);
  const std::string before = text_of(recording_), link = (folder_ / "link").string();
  std::filesystem::create_symlink(recording_, link);
  for (const std::string& output : {recording_, link, (folder_ / "." / "r.tactel").string()})
    for (const char* option : {"--output", "--frames"}) {
      std::vector<std::string> arguments{option, output, "--force"};
      if (option != std::string("--output")) arguments.insert(arguments.end(), {"--output", "/dev/null"});
      const ChildResult refused = record(arguments, "replay:" + recording_ + "?paced=0");
      EXPECT_EQ(refused.exit_code, 2) << option << " " << output << refused.err;
      ASSERT_EQ(text_of(recording_), before);
    }
}

TEST_F(Record, ACutOffRecordingSaysSoAtReplay) {
  ASSERT_EQ(record({"--output", recording_}).exit_code, 0);
  std::filesystem::resize_file(recording_, std::filesystem::file_size(recording_) / 2);
  const ChildResult cut = replay();
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_THAT(cut.err, HasSubstr("cut off"));
  EXPECT_EQ(lines_of(cut.err.substr(cut.err.rfind("\n{") + 1)).back()["cut_short"], true);
  const ChildResult again =
      run_tactel({"record", "--source", "replay:" + recording_, "--output", (folder_ / "b").string()});
  EXPECT_THAT(again.err, HasSubstr("cut off"));
}

TEST_F(Record, AnArrivalThatIsNoTimeIsNamedAndNotReadAsOne) {
  hw::RecordingWriter writer(recording_, open_source(simulation, "", "").profile.text);
  const std::uint8_t bytes[] = {0xA5};
  writer.write({bytes, std::nan("")});
  writer.finish();
  const ChildResult damaged = replay();
  EXPECT_EQ(damaged.exit_code, 2) << damaged.err;
  EXPECT_THAT(damaged.err, HasSubstr("no time"));
  EXPECT_THAT(damaged.err + damaged.out, ::testing::Not(HasSubstr("nan,")));
}

// 0.5 s at 100 Hz, however long the reading takes.
TEST_F(Record, CountsTheTimeOfASimulatedSensorItself) {
  const std::string frames = (folder_ / "frames.csv").string();
  ASSERT_EQ(record({"--output", recording_, "--frames", frames, "--seconds", "0.5"}).exit_code, 0);
  const std::string table = text_of(frames);
  EXPECT_EQ(std::ranges::count(table, '\n'), 1 + 50);
}

// Bytes without the sync of the simulation's frames, and no byte at all. Neither changes the exit code.
TEST_F(Record, WarnsWhereNothingWasDecoded) {
  const std::string profile = open_source(simulation, "", "").profile.text;
  const std::vector<std::uint8_t> noise(1000, 0x55);
  for (const bool any : {true, false}) {
    hw::RecordingWriter writer(recording_, profile, hw::OutputFile::Existing::replace);
    if (any) writer.write({noise, 0.5});
    writer.finish();
    const std::string what = any ? "no frame was found in 1000 bytes" : "no byte came";
    const ChildResult monitored = replay();
    EXPECT_EQ(monitored.exit_code, 0);
    EXPECT_THAT(monitored.err, HasSubstr("warning: replay:" + recording_ + ": " + what));
    const ChildResult recorded = run_tactel({"record", "--source", "replay:" + recording_, "--output", "/dev/null"});
    EXPECT_EQ(recorded.exit_code, 0);
    EXPECT_THAT(recorded.err, HasSubstr("warning: replay:" + recording_ + ": " + what));
    EXPECT_EQ(record({"--output", "/dev/null"}, "replay:" + recording_).err, "");
  }
  EXPECT_THAT(run_tactel({"record", "--source", simulation, "--output", "/dev/null"}).err,
              ::testing::Not(HasSubstr("warning")));
}

}  // namespace tactel::host::record_command_test
