// SPDX-License-Identifier: Apache-2.0

// Serial ports, played by pseudo-terminals.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "hw/serial_port.h"
#include "tests/hw/serial_rate.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace tactel::hw::serial_source_test {

using ::testing::HasSubstr;

/// The other end of a port.
class Board {
 public:
  Board() : file_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    EXPECT_TRUE(file_ >= 0 && ::grantpt(file_) == 0 && ::unlockpt(file_) == 0);
    path = ::ptsname(file_);
  }
  ~Board() { unplug(); }
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;
  void unplug() {
    if (file_ >= 0) ::close(std::exchange(file_, -1));
  }
  void send(const std::vector<std::uint8_t>& bytes) {
    EXPECT_EQ(::write(file_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  int file() const { return file_; }
  std::vector<std::uint8_t> received() const {
    std::vector<std::uint8_t> bytes(64);
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(::read(file_, bytes.data(), bytes.size()), 0)));
    return bytes;
  }
  std::string path;

 private:
  int file_;
};

TEST(SerialSource, EveryByteComesAsItWasSent) {
  Board board;
  SerialSource source(board.path, {.baud = 921600});
  EXPECT_FALSE(source.wait(0.01));
  std::vector<std::uint8_t> sent(256);  // with Ctrl-C, Ctrl-D, Ctrl-S, line ends
  for (std::size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<std::uint8_t>(i);
  board.send(sent);
  std::vector<std::uint8_t> found;
  while (const auto packet = source.wait(0.2)) found.insert(found.end(), packet->bytes.begin(), packet->bytes.end());
  EXPECT_EQ(found, sent);
  EXPECT_EQ(source.counts().bytes, 256u);
  EXPECT_EQ(serial_rate(board.file()), 921600u);
}

TEST(SerialSource, SendsWhatStartsTheDevice) {
  Board board;
  const std::vector<std::uint8_t> start{0xF0, 0x03, 0x0A, 0xC5};
  SerialSource source(board.path, {.start = start});
  EXPECT_EQ(board.received(), start);
}

/// What the board hears within `seconds` while its reader waits.
std::vector<std::uint8_t> heard(const Board& board, SerialSource& source, double seconds) {
  for (const auto start = std::chrono::steady_clock::now();
       std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < seconds;)
    source.wait(0.05);
  return board.received();
}

// A board that boots hears nothing, or prints what is no frame: it is called each second until a frame has come.
TEST(SerialSource, CallsADeviceUntilItAnswers) {
  Board board;
  SerialSource source(board.path, {.start = {'S'}});
  EXPECT_EQ(board.received(), std::vector<std::uint8_t>{'S'});
  board.send({'b', 'o', 'o', 't', '\n'});
  EXPECT_EQ(heard(board, source, 1.5), std::vector<std::uint8_t>{'S'});
  source.answered();
  EXPECT_THAT(heard(board, source, 1.5), testing::IsEmpty());
}

TEST(SerialSource, WaitsBeforeItCalls) {
  Board board;
  SerialSource source(board.path, {.start = {'S'}, .wait = 0.8});
  EXPECT_THAT(heard(board, source, 0.4), testing::IsEmpty());
  EXPECT_EQ(heard(board, source, 1), std::vector<std::uint8_t>{'S'});
}

// Its name leads to another pseudo-terminal then, as that of a board to another device.
TEST(SerialSource, WaitsForAnUnpluggedBoard) {
  const ScratchFolder folder;
  const std::filesystem::path name = folder / "board";
  auto board = std::make_unique<Board>();
  std::filesystem::create_symlink(board->path, name);
  SerialSource source(name, {.start = {'S'}});
  const int file = source.fd();
  board->send({1});
  ASSERT_TRUE(source.wait(1));
  source.answered();
  std::filesystem::remove(name);
  board.reset();
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(source.wait(0.05));
  board = std::make_unique<Board>();
  std::filesystem::create_symlink(board->path, name);
  EXPECT_EQ(heard(*board, source, 0.5), std::vector<std::uint8_t>{'S'});
  board->send({2});
  const auto packet = source.wait(1);
  ASSERT_TRUE(packet);
  EXPECT_TRUE(packet->after_gap);
  EXPECT_EQ(packet->bytes[0], 2);
  EXPECT_EQ(source.counts().reconnects, 1u);
  EXPECT_EQ(source.fd(), file) << "an event loop keeps it";
  board->send({3});
  const auto next = source.wait(1);
  EXPECT_TRUE(next && !next->after_gap);
}

TEST(SerialSource, TakesAnyRate) {
  const Board board;
  for (const int rate : {12345, 1500000, 9600}) {
    const SerialPort port(board.path, {.baud = rate});
    EXPECT_EQ(serial_rate(board.file()), static_cast<unsigned>(rate));
  }
}

TEST(SerialSource, WrongPortsAreNamed) {
  const Board board;
  const auto refused = [](const std::string& path, int baud) {
    return thrown_message<SourceError>([&] { SerialPort(path, {.baud = baud}); });
  };
  EXPECT_THAT(refused(board.path, 0), HasSubstr("a rate of 0 baud; give one above 0"));
  EXPECT_THAT(refused("/no/such", 9600), HasSubstr("serial:/no/such: cannot be opened: No such file"));
  EXPECT_THAT(refused("/dev/null", 9600), HasSubstr("is no serial port"));
}

}  // namespace tactel::hw::serial_source_test
