// SPDX-License-Identifier: Apache-2.0

// Serial ports, played by pseudo-terminals.
#include "hw/serial_source.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/thrown_message.h"

namespace tactel::hw {
namespace {

using ::testing::HasSubstr;

/// The other end of a port.
class Board {
 public:
  Board() : file_(::posix_openpt(O_RDWR | O_NOCTTY)) {
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
  std::vector<std::uint8_t> received() {
    std::vector<std::uint8_t> bytes(64);
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(::read(file_, bytes.data(), bytes.size()), 0)));
    return bytes;
  }
  termios settings() const {
    termios found{};
    EXPECT_EQ(::tcgetattr(file_, &found), 0);
    return found;
  }
  std::string path;

 private:
  int file_;
};

TEST(SerialSource, EveryByteComesAsItWasSent) {
  Board board;
  SerialSource source(board.path, 921600);
  EXPECT_FALSE(source.wait(0.01));
  std::vector<std::uint8_t> sent(256);  // with Ctrl-C, Ctrl-D, Ctrl-S, line ends
  for (std::size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<std::uint8_t>(i);
  board.send(sent);
  std::vector<std::uint8_t> found;
  while (const auto packet = source.wait(0.2)) found.insert(found.end(), packet->bytes.begin(), packet->bytes.end());
  EXPECT_EQ(found, sent);
  EXPECT_EQ(source.counts().bytes, 256u);
  const termios settings = board.settings();
  EXPECT_EQ(::cfgetispeed(&settings), static_cast<speed_t>(B921600));
}

TEST(SerialSource, SendsWhatStartsTheDevice) {
  Board board;
  const std::vector<std::uint8_t> start{0xF0, 0x03, 0x0A, 0xC5};
  const SerialSource source(board.path, 115200, start);
  EXPECT_EQ(board.received(), start);
}

TEST(SerialSource, AnUnpluggedBoardIsAnError) {
  Board board;
  SerialSource source(board.path, 115200);
  board.unplug();
  EXPECT_THAT(thrown_message<SourceError>([&] { source.wait(1); }), HasSubstr("unplugged?"));
}

TEST(SerialSource, WrongPortsAreNamed) {
  const Board board;
  const auto refused = [](const std::string& path, int baud) {
    return thrown_message<SourceError>([&] { SerialPort(path, baud); });
  };
  EXPECT_THAT(refused(board.path, 12345), HasSubstr("a rate of 12345 baud; give one of 9600, 19200"));
  EXPECT_THAT(refused("/no/such", 9600), HasSubstr("serial:/no/such: cannot be opened: No such file"));
  EXPECT_THAT(refused("/dev/null", 9600), HasSubstr("is no serial port"));
}

}  // namespace
}  // namespace tactel::hw
