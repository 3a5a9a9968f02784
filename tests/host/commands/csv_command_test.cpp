// SPDX-License-Identifier: Apache-2.0

// Lines of numbers through record, tare and monitor, as a user runs them.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include "hw/decoder.h"
#include "tests/host/commands/live_command.h"

namespace tactel::host {
namespace {

using ::testing::HasSubstr;

/// The simulated sensor's frames as lines of numbers, and a profile with its channels and calibration.
class CsvCommand : public LiveCommand {
 protected:
  CsvCommand() {
    const auto [bytes, simulated] = simulated_bytes();
    hw::Decoder decoder(simulated.format());
    std::string lines = "time";
    for (int channel = 0; channel < 42; ++channel) lines += fmt::format(",channel {}", channel);
    lines += "\n";
    decoder.feed(bytes, [&](const hw::DecodedFrame& frame) {
      lines += fmt::format("{},{}\n", *frame.device_time, fmt::join(frame.values, ","));
    });
    file_ = folder_.write("frames.csv", lines);
    const std::string text = simulated.text;
    profile_ =
        folder_.write("csv.toml", "[format]\nkind = \"csv\"\nchannels = 42\n" + text.substr(text.find("[channels]")));
  }
  ChildResult run(const std::string& command, const std::string& source, std::vector<std::string> more = {}) const {
    more.insert(more.end(), {"--profile", profile_});
    return run_tactel({command, "--source", source}, more);
  }
  std::string file_, profile_;
};

/// Frames, times and S of monitor's lines.
void expect_same_answers(const std::string& out, const std::string& expected) {
  const auto lines = lines_of(out), others = lines_of(expected);
  ASSERT_EQ(lines.size(), others.size());
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (const char* key : {"frame", "slip_index", "contact"}) EXPECT_EQ(lines[i][key], others[i][key]) << i << key;
}

// The same frames by another way: the same S, from a file, a pipe, and a recording of either.
TEST_F(CsvCommand, TheSameFramesGiveTheSameS) {
  const std::string expected = run_tactel({"monitor", "--source", simulation, "--network", network_}).out;
  const ChildResult from_file = run("monitor", "csv:" + file_, {"--network", network_});
  ASSERT_EQ(from_file.exit_code, 0) << from_file.err;
  expect_same_answers(from_file.out, expected);
  EXPECT_NEAR(lines_of(from_file.out)[320]["device_time"].get<double>(), 3.2, 1e-9);
  EXPECT_NEAR(lines_of(from_file.out)[320]["arrival"].get<double>(), 3.2, 1e-9);

  const std::string piped = fmt::format("cat {} | {} record --source csv:- --profile {} --output {}", file_,
                                        TACTEL_PROGRAM, profile_, recording_);
  const ChildResult recorded = run_child({"sh", "-c", piped});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_THAT(recorded.err, HasSubstr("321 frames"));
  EXPECT_THAT(recorded.err, HasSubstr("lost 0, bad 0"));
  expect_same_answers(run_tactel({"monitor", "--source", "replay:" + recording_, "--network", network_}).out, expected);
}

// Lines that somebody else's program wrote at rest: their means, by hand.
TEST_F(CsvCommand, TareTakesTheMeansOfTwoSeconds) {
  std::string lines = "time;z;x\n";
  for (int i = 0; i < 300; ++i) lines += fmt::format("{};{};-7\n", 0.01 * i, i > 200 ? 1e6 : 500 + i % 2);
  const std::string profile =
      folder_.write("two.toml", "[format]\nkind = \"csv\"\nchannels = 2\n[channels]\nnormal = [0]\nshear = [1]\n");
  const std::string output = (folder_ / "c.toml").string();
  const ChildResult tared = run_tactel(
      {"tare", "--source", "csv:" + folder_.write("rest.csv", lines), "--profile", profile, "--output", output});
  ASSERT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_THAT(tared.err, HasSubstr("the mean of 201 frames"));
  EXPECT_THAT(text_of(output), HasSubstr(fmt::format("offset = [{}, -7]", 500 + 100 / 201.0)));
}

TEST_F(CsvCommand, WrongCallsAreNamed) {
  const std::string network = "--network", out = "--output";
  EXPECT_TRUE(is_refused(run_tactel({"monitor", "--source", "csv:" + file_, network, network_}),
                         {"--profile", "format.kind is csv"}));
  const std::string board = folder_.write("board.toml", "[format]\nkind = \"glove\"\n[channels]\nnormal = [0]\n");
  EXPECT_TRUE(is_refused(run_tactel({"record", "--source", "csv:" + file_, "--profile", board, out, recording_}),
                         {board, "format.kind", "glove", "csv"}));
  EXPECT_TRUE(is_refused(run("record", "usb:1209:0001", {out, recording_}), {"format.kind", "csv"}));
  EXPECT_TRUE(is_refused(run("record", "csv:" + file_ + "?rate=3", {out, recording_}), {"rate"}));
  EXPECT_TRUE(is_refused(run("record", "csv:" + file_, {out, file_, "--force"}), {"another file"}));
  EXPECT_TRUE(is_refused(run("record", "csv:" + folder_.write("e.csv", ""), {out, recording_}),
                         {"e.csv: ended without a line of numbers"}));
  EXPECT_TRUE(is_refused(run("monitor", "csv:" + folder_.write("x.csv", "1,2\n"), {network, network_}),
                         {"x.csv:1: 2 fields; a line has 42 numbers"}));
  const ChildResult cut =
      run("record", "csv:" + folder_.write("c.csv", text_of(file_) + "3.3,1"), {out, recording_, "--force"});
  EXPECT_EQ(cut.exit_code, 0);
  EXPECT_THAT(cut.err, HasSubstr("was cut off"));
}

TEST_F(CsvCommand, ProfilesNameWhatTheyReject) {
  const auto refused = [&](const std::string& format, const char* key) {
    const std::string profile = folder_.write("p.toml", "[format]\n" + format + "[channels]\nnormal = [0]\n");
    return is_refused(run_tactel({"record", "--source", "csv:" + file_, "--profile", profile, "--output", recording_}),
                      {key});
  };
  EXPECT_TRUE(refused("kind = \"csv\"\n", "channels"));
  EXPECT_TRUE(refused("kind = \"csv\"\nchannels = 0\n", "channels"));
  EXPECT_TRUE(refused("kind = \"csv\"\nchannels = 2000\n", "channels"));
  EXPECT_TRUE(refused("kind = \"csv\"\nchannels = 2\nsync = [1]\n", "sync"));
}

}  // namespace
}  // namespace tactel::host
