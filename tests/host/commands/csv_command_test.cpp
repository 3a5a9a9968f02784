// SPDX-License-Identifier: Apache-2.0

// Lines of numbers through record, tare and monitor, as a user runs them.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "hw/decoder.h"
#include "tests/host/commands/live_command.h"

namespace tactel::host::csv_command_test {

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

TEST_F(CsvCommand, MonitorGoesOnAfterABadLineOfAPipe) {
  const std::string piped =
      fmt::format("sed '5s/.*/brown-out/' {} | {} monitor --source csv:- --profile {} --network {} --late 100", file_,
                  TACTEL_PROGRAM, profile_, network_);
  const ChildResult result = run_child({"sh", "-c", piped});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(lines_of(result.out).size(), 320u);
  EXPECT_THAT(result.err, HasSubstr("1 line was left out, the first: csv:-:5: fields = 1: must be 43"));
  EXPECT_THAT(result.err.substr(result.err.rfind('{', result.err.rfind("latency"))), HasSubstr("\"bad\": 1,"));
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

TEST_F(CsvCommand, MistakesOfACallAreNamed) {
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
                         {"x.csv:1: fields = 2: must be 42"}));
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

/// Two pads whose readings differ, as the lines of a gripper, and a network of 16 tactels with three axes.
class PadCommand : public LiveCommand {
 protected:
  PadCommand() {
    write_onnx(network_, network(24));
    std::string left = "time" + std::string(48, ',') + "\n", right = left;
    std::string both = "time" + std::string(96, ',') + "\n";
    for (int i = 0; i < frames; ++i) {
      const auto readings = [&](double pressure, double drag) {
        std::string line;
        for (int tactel = 0; tactel < 16; ++tactel) {
          const double share = 1 + 0.1 * tactel;
          line += fmt::format("{}{},{},{}", tactel == 0 ? "" : ",", 16000 + drag * share, 16500 - drag,
                              39000 + pressure * share + tactel * i % 3);
        }
        return line;
      };
      const double grip = i < 250 ? 0 : 4.0 * (i - 250);
      const std::string a = readings(grip, 0.3 * grip), b = readings(0.5 * grip, -0.02 * i * (i >= 250));
      const std::string time = fmt::format("{},", 0.01 * i);
      left += fmt::format("{}{}\n", time, a), right += fmt::format("{}{}\n", time, b);
      both += fmt::format("{}{},{}\n", time, a, b);
    }
    left_ = "csv:" + folder_.write("left.csv", left), right_ = "csv:" + folder_.write("right.csv", right);
    file_ = folder_.write("both.csv", both);
  }
  ChildResult run(const std::string& command, const std::string& source, std::vector<std::string> more = {}) const {
    more.insert(more.end(), {"--profile", "uskin-4x4"});
    return run_tactel({command, "--source", source}, more);
  }
  /// Offsets and noise of the first two seconds, which are at rest.
  std::string tare(const std::string& source, const std::string& name, std::vector<std::string> more = {}) const {
    std::string output = (folder_ / name).string();
    more.insert(more.end(), {"--output", output});
    const ChildResult result = run("tare", source, more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return output;
  }
  static constexpr int frames = 500;
  std::string left_, right_, file_;
  const std::vector<std::string> second_{"--profile", "uskin-4x4"};
};

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// The pads' S, as lines of each pad alone have them.
void expect_pads(const std::vector<nlohmann::json>& both, const std::vector<nlohmann::json>& left,
                 const std::vector<nlohmann::json>& right, double alarm) {
  ASSERT_EQ(both.size(), left.size());
  bool on = false;
  int begins = 0;
  for (std::size_t i = 0; i < both.size(); ++i) {
    for (const auto& [pad, alone] : {std::pair{both[i]["pads"][0], left[i]}, {both[i]["pads"][1], right[i]}})
      for (const char* key : {"slip_index", "contact"}) EXPECT_EQ(pad[key], alone[key]) << i << key;
    const auto number = [&](const nlohmann::json& of) {
      return of["slip_index"].is_null() ? -1 : of["slip_index"].get<double>();
    };
    const double larger = std::max(number(left[i]), number(right[i]));
    EXPECT_EQ(number(both[i]), larger) << i;
    EXPECT_EQ(both[i]["contact"], left[i]["contact"] == true || right[i]["contact"] == true) << i;
    if (larger >= alarm && !on) ++begins;
    on = larger >= alarm || (on && larger >= alarm - 0.05);
    EXPECT_EQ(both[i]["alarm"], on) << i;
  }
  EXPECT_GT(begins, 0);
}

// tare, record, replay and monitor of two pads in a line: each pad as by itself, the alarm by the larger S.
TEST_F(PadCommand, TwoPadsOfALine) {
  const std::vector<std::string> calibration = {"--calibration", tare("csv:" + file_, "both.toml", second_)};
  const std::vector<std::string> of_each = {"--calibration", tare(left_, "left.toml"), "--calibration",
                                            tare(right_, "right.toml")};
  const std::vector<std::string> network = {"--network", network_, "--alarm", "0.4"};
  const auto left = lines_of(run("monitor", left_, with({of_each[0], of_each[1]}, network)).out);
  const auto right = lines_of(run("monitor", right_, with({of_each[2], of_each[3]}, network)).out);
  ASSERT_EQ(left.size(), static_cast<std::size_t>(frames));

  const ChildResult by_one = run("monitor", "csv:" + file_, with(with(second_, calibration), network));
  ASSERT_EQ(by_one.exit_code, 0) << by_one.err;
  expect_pads(lines_of(by_one.out), left, right, 0.4);
  const ChildResult by_each = run("monitor", "csv:" + file_, with(with(second_, of_each), network));
  expect_pads(lines_of(by_each.out), left, right, 0.4);

  const ChildResult recorded = run("record", "csv:" + file_, with(second_, {"--output", recording_}));
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const ChildResult replayed =
      run_tactel(with({"monitor", "--source", "replay:" + recording_}, with(calibration, network)));
  ASSERT_EQ(replayed.exit_code, 0) << replayed.err;
  expect_pads(lines_of(replayed.out), left, right, 0.4);
  const ChildResult view = run("monitor", "csv:" + file_, with(with(second_, calibration), with(network, {"--view"})));
  EXPECT_THAT(view.out, HasSubstr("█████"));
}

// Raw counts are no stresses before a tare: no S, no alarm, but the command to run.
TEST_F(PadCommand, WithoutAZeroThereIsNoS) {
  const std::vector<std::string> monitor = {"--network", network_, "--touch", "1e-4", "--alarm", "0.8"};
  EXPECT_TRUE(is_refused(run("monitor", left_, monitor), {"--calibration", "no reading at rest", "tactel tare"}));
  const ChildResult recorded = run("record", left_, {"--output", recording_});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const std::vector<std::string> replay = {"monitor", "--source", "replay:" + recording_};
  EXPECT_TRUE(is_refused(run_tactel(with(replay, monitor)), {"--calibration", "tactel tare"}));
  const ChildResult tared = run_tactel(with(with(replay, monitor), {"--calibration", tare(left_, "left.toml")}));
  EXPECT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_EQ(lines_of(tared.out)[0]["contact"], false) << "at rest";
}

// A reader that attaches within a line, and a board that prints a word.
TEST_F(PadCommand, ABadLineOfAPipeCountsAndTheNextIsAFrame) {
  const std::string profile =
      folder_.write("q.toml",
                    "[format]\nkind = \"csv\"\nchannels = 3\n[pad]\ntactels = [1, 1]\n[channels]\n"
                    "normal = [0]\nshear_x = [1]\nshear_y = [2]\n");
  const std::string frames = (folder_ / "frames.csv").string();
  const std::string piped = fmt::format(
      "printf '0,39\\n40,41,39\\n41,40,39\\nbrown-out\\n40,40,40\\n' | {} record --source csv:- --profile {} --output "
      "{} "
      "--frames {}",
      TACTEL_PROGRAM, profile, recording_, frames);
  const ChildResult recorded = run_child({"sh", "-c", piped});
  EXPECT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_THAT(recorded.err, HasSubstr("3 frames"));
  EXPECT_THAT(recorded.err, HasSubstr("bad 2"));
  EXPECT_THAT(recorded.err, HasSubstr("2 lines were left out, the first: csv:-:1: fields = 2: must be 3"));
  const std::string table = text_of(frames);
  EXPECT_EQ(std::ranges::count(table, '\n'), 4) << table;
}

TEST_F(PadCommand, MistakesOfACallAreNamed) {
  const std::vector<std::string> monitor = {"--network", network_};
  EXPECT_TRUE(is_refused(run("record", "csv:" + file_, {"--output", recording_}), {"names = 97", "49"}));
  EXPECT_TRUE(is_refused(run("monitor", "csv:" + file_, with(monitor, {"--profile", "glove"})), {"csv"}));
  EXPECT_TRUE(is_refused(run("monitor", "replay:" + file_, with(monitor, second_)), {"--profile", "csv:"}));
  const std::string own = tare(left_, "left.toml");
  EXPECT_TRUE(is_refused(run("monitor", left_, with(monitor, {"--calibration", own, "--calibration", own})),
                         {"--calibration", "once for each --profile"}));
  EXPECT_TRUE(is_refused(run("monitor", "csv:" + file_, with(with(monitor, second_), {"--calibration", own})),
                         {"calibration.offset", "96"}));
}

// 96 numbers a line at 1 kHz by the clock; the lines are whole and in their order.
TEST_F(PadCommand, AThousandLinesASecondThroughAPipe) {
  const std::vector<std::string> calibrated =
      with(second_, {"--calibration", tare("csv:" + file_, "both.toml", second_)});
  const std::string pipe = (folder_ / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::istringstream text(text_of(file_));
  std::jthread sender([&] {
    std::ofstream out(pipe);
    auto next = std::chrono::steady_clock::now();
    for (std::string line; std::getline(text, line); next += std::chrono::milliseconds(1)) {
      std::this_thread::sleep_until(next);
      out << line << std::endl;
    }
  });
  // A test on a busy machine: no frame is lost, however late.
  const ChildResult result =
      run("monitor", "csv:" + pipe, with(calibrated, {"--network", network_, "--touch", "0", "--late", "100"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i)
    EXPECT_NEAR(lines[static_cast<std::size_t>(i)]["device_time"].get<double>(), 0.01 * i, 1e-9);
  const auto summary = lines_of(result.err).back();
  for (const char* key : {"lost", "bad", "late"}) EXPECT_EQ(summary[key], 0) << key;
}

}  // namespace tactel::host::csv_command_test
