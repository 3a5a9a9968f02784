// SPDX-License-Identifier: Apache-2.0

// Lines of numbers from files and pipes.
#include "host/live/csv_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "host/live/frame_reader.h"
#include "host/live/open_source.h"
#include "hw/formats.h"
#include "tests/hw/serial_rate.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace tactel::host::csv_source_test {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Values = std::vector<std::vector<double>>;

struct Seen {
  Values values;
  std::vector<std::optional<double>> times;
  std::vector<double> arrivals;
};

/// The frames of a source until it ends or `most` are seen.
Seen read(hw::FrameSource& source, int channels, std::size_t most = 1'000'000) {
  Seen seen;
  hw::Decoder decoder(hw::csv_format(channels));
  read_frames(source, decoder,
              {.frame =
                   [&](const hw::DecodedFrame& frame, double arrival) {
                     seen.values.emplace_back(frame.values.begin(), frame.values.end());
                     seen.times.push_back(frame.device_time);
                     seen.arrivals.push_back(arrival);
                   },
               .stop = [&] { return seen.values.size() >= most; }});
  EXPECT_EQ(decoder.counts().lost + decoder.counts().bad + decoder.counts().discarded, 0u);
  return seen;
}

class CsvFile : public ::testing::Test {
 protected:
  Seen read_text(const std::string& text, int channels) const {
    CsvSource source(folder_.write("a.csv", text), static_cast<std::size_t>(channels), false);
    return read(source, channels);
  }
  std::string refused(const std::string& text, int channels) const {
    std::string message = thrown_message<hw::RecordingError>([&] { read_text(text, channels); });
    const std::size_t at = message.find("a.csv");
    return at == std::string::npos ? message : message.substr(at);
  }
  const ScratchFolder folder_;
};

TEST_F(CsvFile, TakesEverySeparatorAndEndOfLine) {
  const Values expected = {{1, -2.5, 300}, {4, 5, 6}};
  for (const char* text : {"1,-2.5,3e2\n4,5,6\n", "1;-2,5;3e2\r\n4;5;6\r\n", "1\t-2.5\t3e2\n4\t5\t6\n",
                           " 1 , -2.50,+300 \n\n  \r\n4,5,6\n\n", "\xEF\xBB\xBF\x31,-2.5,300\n4,5,6\n",
                           "a,b,c\n1,-2.5,300\n4,5,6\n", "\n\"x y\",2,3\n1,-2.5,300\n4,5,6\n"}) {
    const Seen seen = read_text(text, 3);
    EXPECT_EQ(seen.values, expected) << text;
    EXPECT_EQ(seen.times.front(), std::nullopt);
  }
  EXPECT_EQ(read_text("7\n8\n", 1).values, (Values{{7}, {8}}));
}

// The header decides whether the first number is a time; frames then arrive at it, from 0 on.
TEST_F(CsvFile, AHeaderSaysWhetherLinesHaveATime) {
  for (const char* name : {"time", "Time", " TIME ", "\"time\"", "# time", "\xEF\xBB\xBFtime"}) {
    const Seen seen = read_text(std::string(name) + ",a,b\n10.5,1,2\n10.75,3,4\n10.75,5,6\n", 2);
    EXPECT_EQ(seen.values, (Values{{1, 2}, {3, 4}, {5, 6}})) << name;
    EXPECT_THAT(seen.arrivals, ElementsAre(0, 0.25, 0.25));
    ASSERT_TRUE(seen.times[1].has_value());
    EXPECT_NEAR(*seen.times[1], 10.75, 1e-9);
  }
}

TEST_F(CsvFile, NamesLineProblemAndFix) {
  EXPECT_EQ(refused("1,2,3\n1,2\n", 3), "a.csv:2: fields = 2: must be 3: one for each of the profile's channels");
  EXPECT_EQ(refused("time,a,b\n1,2\n", 2),
            "a.csv:2: fields = 2: must be 3: one for each of the profile's channels, behind the time");
  EXPECT_THAT(refused("0.1,1,2\n", 2), HasSubstr("a.csv:1: fields = 3"));
  EXPECT_THAT(refused("stamp,a,b\n1,2,3\n", 2), HasSubstr("a.csv:1: names = 3: must be 2"));
  EXPECT_THAT(refused("time,a\n1,2\n", 2), HasSubstr("a.csv:1: names = 2: must be 3"));
  EXPECT_THAT(refused("\n1,2\n\n1,x\x1b[2J\n", 2), HasSubstr("a.csv:4: column 2 = x [2J: must be a finite number"));
  EXPECT_THAT(refused("1,2\na,b\n", 2), HasSubstr("a.csv:2: column 1 = a:"));
  EXPECT_THAT(refused("1,2\n" + std::string(100'000, '1') + "\n", 2), HasSubstr("a.csv:2: line = (long): must be at"));
  EXPECT_THAT(refused(std::string(100'000, '1'), 2), HasSubstr("a.csv:1: line = (long)"));
  EXPECT_THAT(refused("time,a\n-1,2\n", 1), HasSubstr("a.csv:2: time = -1:"));
  EXPECT_THAT(refused("time,a\n1e10,2\n", 1), HasSubstr("a.csv:2: time = 10000000000:"));
  EXPECT_THAT(refused("time,a\n2,2\n1.5,2\n", 1), HasSubstr("a.csv:3: time = 1.5: must be that of the line above"));
  EXPECT_THAT(refused("time,a\n0,2\n1.7e9,2\n", 1), HasSubstr("of the first; sort the lines by time"));
  for (const char* empty : {"", "\n\n", "time,a\n", "1"})
    EXPECT_EQ(refused(empty, 1), "a.csv: ended without a line of numbers; write a line for each frame") << empty;
  const auto message = [](const std::string& path, bool paced) {
    return thrown_message<hw::RecordingError>([&] {
      CsvSource source(path, 2, paced);
      read(source, 2);
    });
  };
  EXPECT_THAT(message(folder_.write("b.csv", "1,2\n"), true),
              HasSubstr("b.csv:1: time = none: must be given: a header"));
  EXPECT_THAT(message((folder_ / "none").string(), false), HasSubstr("cannot be read: No such file"));
  EXPECT_THAT(message("/tmp", false), HasSubstr("csv:/tmp: cannot be read"));
  EXPECT_THAT(message("/dev/null", true), HasSubstr("leave paced=1 out"));
}

// What stands in front of a wrong line is not lost.
TEST_F(CsvFile, FramesInFrontOfAWrongLineCount) {
  CsvSource source(folder_.write("a.csv", "1\n2\nx\n3\n"), 1, false);
  EXPECT_TRUE(source.wait(0) && source.wait(0));
  for (int i = 0; i < 2; ++i) EXPECT_THROW(source.wait(0), hw::RecordingError);
}

TEST_F(CsvFile, ALastLineWithoutItsEndIsLeftOut) {
  CsvSource source(folder_.write("a.csv", "1,2\n3,4"), 2, false);
  EXPECT_EQ(read(source, 2).values, (Values{{1, 2}}));
  EXPECT_TRUE(source.finished() && source.cut_short());
  CsvSource whole(folder_.write("b.csv", "1,2\n  "), 2, false);
  read(whole, 2);
  EXPECT_FALSE(whole.cut_short());
}

// As fast as it is taken, or at its times.
// So that a signal is heard: whoever reads is asked again and again whether to go on.
TEST_F(CsvFile, BlankLinesAreReadAPartAtATime) {
  CsvSource source(folder_.write("a.csv", std::string(8 << 20, '\n') + "1,2\n"), 2, false);
  EXPECT_FALSE(source.wait(1));
  EXPECT_LE(source.counts().bytes, 2u << 20);
  EXPECT_FALSE(source.finished());
  EXPECT_EQ(read(source, 2).values, (Values{{1, 2}}));
}

TEST_F(CsvFile, PacedGivesItsTimesAsThePace) {
  const std::string path = folder_.write("a.csv", "time,a\n100,1\n100.1,2\n100.3,3\n");
  for (const bool paced : {false, true}) {
    CsvSource source(path, 1, paced);
    const auto start = Clock::now();
    EXPECT_THAT(read(source, 1).arrivals,
                ElementsAre(0, ::testing::DoubleNear(0.1, 1e-9), ::testing::DoubleNear(0.3, 1e-9)));
    EXPECT_EQ(seconds_since(start) >= 0.3, paced);
    EXPECT_GE(source.now(), 0.3 - 1e-9);
  }
  CsvSource source(path, 1, true);
  EXPECT_TRUE(source.wait(0.01));
  EXPECT_FALSE(source.wait(0.01));  // not yet
  EXPECT_FALSE(source.finished());
}

/// A named pipe, opened by the source before its writer.
class CsvPipe : public ::testing::Test {
 protected:
  CsvPipe() {
    ::mkfifo(path_.c_str(), 0600);
    source_.emplace(path_, 2, false);
  }
  void open_writer() { writer_ = ::open(path_.c_str(), O_WRONLY); }
  void write(std::string_view text) const {
    ASSERT_EQ(::write(writer_, text.data(), text.size()), ssize_t(text.size()));
  }
  void close_writer() { ::close(std::exchange(writer_, -1)); }
  ~CsvPipe() override {
    if (writer_ >= 0) close_writer();
  }
  const ScratchFolder folder_;
  const std::string path_ = (folder_ / "pipe").string();
  std::optional<CsvSource> source_;
  int writer_ = -1;
};

// A pipe that stays open is no end, and half a line no frame; the end of its writer is the end.
TEST_F(CsvPipe, WaitsForLines) {
  EXPECT_TRUE(source_->live());
  EXPECT_FALSE(source_->wait(0.01));
  EXPECT_FALSE(source_->finished()) << "its writer is yet to come";
  open_writer();
  write("1,2\n3,");
  EXPECT_TRUE(source_->wait(1));
  const auto start = Clock::now();
  EXPECT_FALSE(source_->wait(0.05));
  EXPECT_GE(seconds_since(start), 0.04);  // ms of poll, rounded down
  EXPECT_FALSE(source_->finished());
  write("4\n5,6\n7");
  const auto packet = source_->wait(1);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->bytes.size(), 2 * hw::csv_format(2)->longest_frame());
  EXPECT_LE(packet->arrival, source_->now());
  close_writer();
  EXPECT_FALSE(source_->wait(1));
  EXPECT_TRUE(source_->finished() && source_->cut_short());
}

TEST_F(CsvPipe, SplitsDoNotMatter) {
  std::string text = "time,a,b\r\n";
  for (int i = 0; i < 40; ++i) text += fmt::format("{},{},{}\r\n", 0.001 * i, i, -i);
  for (const std::size_t part : {1, 2, 7, 64}) {
    source_.emplace(path_, 2, false);
    open_writer();
    std::thread writer([&] {
      for (std::size_t at = 0; at < text.size(); at += part) write(std::string_view(text).substr(at, part));
      close_writer();
    });
    const Seen seen = read(*source_, 2);
    writer.join();
    ASSERT_EQ(seen.values.size(), 40u) << part;
    for (int i = 0; i < 40; ++i)
      EXPECT_EQ(seen.values[static_cast<std::size_t>(i)], (std::vector<double>{1.0 * i, -1.0 * i}));
  }
}

// A reader that attaches within a line, a cut one, a word of the board, one without an end: each is left out, and all
// others are frames. Fields that are no numbers are NaN; a line without any number is none.
TEST_F(CsvPipe, ABadLineCountsAndTheNextIsAFrame) {
  open_writer();
  std::thread writer([&] {
    write("000\n1,2\nnan,4\n,null\n3,4\n5\nrebooting\n" + std::string(2000, '7'));
    write(std::string(2000, '7') + ",8\n5,6\n7,8,9\n");
    close_writer();
  });
  const Seen seen = read(*source_, 2);
  writer.join();
  ASSERT_EQ(seen.values.size(), 4u);
  EXPECT_TRUE(std::isnan(seen.values[1][0]) && seen.values[1][1] == 4);
  EXPECT_EQ((Values{seen.values[0], seen.values[2], seen.values[3]}), (Values{{1, 2}, {3, 4}, {5, 6}}));
  EXPECT_EQ(source_->counts().bad, 6u);
  EXPECT_THAT(source_->first_bad(), HasSubstr("pipe:1: fields = 1: must be 2"));
}

// Lines that are all wrong are another format: that is no stream to wait for.
TEST_F(CsvPipe, AHundredBadLinesWithoutAFrameAreAnError) {
  open_writer();
  for (int i = 0; i < 99; ++i) write("1,2,3\n");
  EXPECT_FALSE(source_->wait(1));
  write("1,2,3\n");
  EXPECT_THAT(
      thrown_message<hw::RecordingError>([&] { source_->wait(1); }),
      HasSubstr("pipe:1: fields = 3: must be 2: one for each of the profile's channels; so were all of the first"));
}

// A board on a serial line that is pulled out is no end of the frames.
TEST(CsvTerminal, ALineThatHangsUpIsAnErrorOfTheDevice) {
  const int board = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(board >= 0 && ::grantpt(board) == 0 && ::unlockpt(board) == 0);
  CsvSource source(::ptsname(board), 2, false);
  ASSERT_EQ(::write(board, "1,2\n", 4), 4);
  EXPECT_TRUE(source.wait(1));
  ::close(board);
  const std::string message = thrown_message<hw::SourceError>([&] { source.wait(1); });
  EXPECT_THAT(message, HasSubstr("unplugged?"));
  EXPECT_THROW(source.wait(1), hw::SourceError);
}

TEST(CsvTerminal, LinesOfASerialPort) {
  const int board = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(board >= 0 && ::grantpt(board) == 0 && ::unlockpt(board) == 0);
  const ScratchFolder folder;
  const std::string profile = folder.write("line.toml",
                                           "[format]\nkind = \"csv\"\nchannels = 2\n[channels]\nnormal = [0, 1]\n"
                                           "[calibration]\noffset = 0\ngain = 1\n");
  const OpenSource opened = open_source(std::string("serial:") + ::ptsname(board) + "?baud=230400", profile, "");
  termios settings{};
  ASSERT_EQ(::tcgetattr(board, &settings), 0);
  EXPECT_EQ(hw::serial_rate(board), 230400u);
  EXPECT_EQ(settings.c_lflag & ECHO, 0u);
  ASSERT_EQ(::write(board, "1,2\r\n3,4\r\n", 10), 10);
  EXPECT_TRUE(opened.source->wait(1));
  EXPECT_TRUE(opened.source->live());
  ::close(board);
}

// A board that boots prints a banner, and streams when it is told to; its rate is that of the profile.
TEST(CsvTerminal, CallsABoardUntilItsFirstLineOfNumbers) {
  const int board = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  ASSERT_TRUE(board >= 0 && ::grantpt(board) == 0 && ::unlockpt(board) == 0);
  const ScratchFolder folder;
  const std::string profile =
      folder.write("line.toml",
                   "[device]\nbaud = 9600\nstart = [83]\n[format]\nkind = \"csv\"\nchannels = 2\n"
                   "[channels]\nnormal = [0, 1]\n[calibration]\noffset = 0\ngain = 1\n");
  const OpenSource opened = open_source(std::string("serial:") + ::ptsname(board), profile, "");
  EXPECT_EQ(hw::serial_rate(board), 9600u);
  ASSERT_EQ(::write(board, "pad v1.2 ready\r\n", 16), 16);
  hw::Decoder decoder(hw::csv_format(2));
  char heard[8] = "";
  const auto began = Clock::now();
  const auto stop = [&] { return seconds_since(began) > 1.5; };
  read_frames(*opened.source, decoder, {.stop = stop});
  EXPECT_EQ(::read(board, heard, sizeof heard), 2) << "at once, and a second later";
  ASSERT_EQ(::write(board, "1,2\r\n", 5), 5);
  EXPECT_TRUE(opened.source->wait(1));
  const auto answered = Clock::now();
  read_frames(*opened.source, decoder, {.stop = [&] { return seconds_since(answered) > 1.2; }});
  EXPECT_LT(::read(board, heard, sizeof heard), 1);
  ::close(board);
}

// Two sensors of a hub write their lines in turn, each with its number.
TEST_F(CsvFile, ALogOfTwoSensorsIsReadOneByOne) {
  const std::string path = folder_.write("a.csv", "time,sensor_id,f\n0,0,10\n0,1,20\n1,0,11\n1,1,21\n");
  for (const int sensor : {0, 1}) {
    CsvSource source(path, 2, false, sensor);
    EXPECT_EQ(read(source, 2).values, (Values{{1.0 * sensor, 10.0 + 10 * sensor}, {1.0 * sensor, 11.0 + 10 * sensor}}));
  }
  EXPECT_THAT(refused("time,sensor_id,f\n0,0,10\n0,1,20\n", 2),
              HasSubstr("a.csv:3: sensor_id = 1: must be 0, as above; csv:FILE?sensor=0"));
  EXPECT_EQ(read_text("time,Sensor ID,f\n0,3,10\n0,3,20\n", 2).values.size(), 2u);
  CsvSource without(folder_.write("b.csv", "a,b\n1,2\n"), 2, false, 1);
  EXPECT_THAT(thrown_message<hw::RecordingError>([&] { read(without, 2); }),
              HasSubstr("no column is called sensor_id"));
}

// 48 numbers at 1 kHz: every frame, in order.
TEST_F(CsvPipe, AThousandFramesASecond) {
  source_.emplace(path_, 48, false);
  open_writer();
  std::thread writer([&] {
    auto due = Clock::now();
    for (int i = 0; i < 1000; ++i, due += 1ms) {
      std::this_thread::sleep_until(due);
      std::string line = std::to_string(i);
      for (int c = 1; c < 48; ++c) line += fmt::format(",{}", 40000 + c + 0.125 * i);
      write(line + "\n");
    }
    close_writer();
  });
  const Seen seen = read(*source_, 48);
  writer.join();
  ASSERT_EQ(seen.values.size(), 1000u);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(seen.values[static_cast<std::size_t>(i)][0], i);
    EXPECT_EQ(seen.values[static_cast<std::size_t>(i)][47], 40047 + 0.125 * i);
  }
  EXPECT_TRUE(std::ranges::is_sorted(seen.arrivals));
}

}  // namespace tactel::host::csv_source_test
