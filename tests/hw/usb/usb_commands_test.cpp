// SPDX-License-Identifier: Apache-2.0

// tactel itself with two sensors of one kind. Its process has the preloaded library and the tree of devices of this
// one.
#include <gmock/gmock.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <fstream>
#include <sstream>

#include "test_paths.h"
#include "tests/hw/usb/emulated_device.h"
#include "tests/scratch.h"

namespace tactel::hw::tests {
namespace {

using ::testing::HasSubstr;

ByteVector frames(int first) {
  ByteVector stream;
  for (int i = 0; i < 10; ++i) append(stream, glove_frame(first + i));
  return stream;
}

class UsbCommands : public ::testing::Test {
 protected:
  UsbCommands() { left_.send(frames(0)), right_.send(frames(1000)); }

  /// Records for a second; what it says on stderr. first_: channel 0 of the first frame, as text.
  std::string record(const std::string& source) {
    const std::string at = folder_ / "", command = std::string(TACTEL_PROGRAM) +
                                                   " record --seconds 1 --force --source '" + source + "' --output " +
                                                   at + "r --frames " + at + "f.csv 2> " + at + "err";
    exit_code_ = WEXITSTATUS(std::system(command.c_str()));
    std::ifstream table(at + "f.csv");
    std::string line;
    std::getline(table, line), std::getline(table, line);
    std::istringstream cells(line);
    for (int i = 0; i < 4; ++i) std::getline(cells, first_, ',');
    return text_of(at + "err");
  }

  EmulatedDevice left_{glove_kind(), 1, "L-7"}, right_{glove_kind(), 2, "R-8"};
  const ScratchFolder folder_;
  std::string first_;
  int exit_code_ = -1;
};

TEST_F(UsbCommands, WithoutAChoiceItSaysWhichItReads) {
  const std::string said = record("usb:glove");
  EXPECT_EQ(exit_code_, 0) << said;
  EXPECT_EQ(first_, "4095");
  EXPECT_THAT(said, HasSubstr("reads the device at port 1-1 (serial number L-7)"));
  EXPECT_THAT(said, HasSubstr("also connected: port 1-2 (serial number R-8)"));
}

TEST_F(UsbCommands, TheSourceChooses) {
  for (const char* source : {"usb:glove?serial=R-8", "usb:glove?port=1-2", "usb:glove?port=1-2&serial=R-8"}) {
    right_.send(frames(1000));
    const std::string said = record(source);
    EXPECT_EQ(exit_code_, 0) << said;
    EXPECT_EQ(first_, "3095") << source;
    EXPECT_THAT(said, ::testing::Not(HasSubstr("note")));
  }
  EXPECT_THAT(record("usb:glove?serial=X"), HasSubstr("no free one with serial number X"));
  EXPECT_EQ(exit_code_, 3);
}

TEST_F(UsbCommands, ABusyDeviceIsPassedOver) {
  left_.set_busy(true);
  const std::string said = record("usb:glove");
  EXPECT_EQ(exit_code_, 0) << said;
  EXPECT_EQ(first_, "3095");
  EXPECT_THAT(said, HasSubstr("port 1-1 (serial number L-7) (not free)"));
}

TEST_F(UsbCommands, DevicesListsSensorsWithTheirSources) {
  EmulatedDevice board(interrupt_kind(), 3);
  const std::string at = folder_ / "", command = std::string(TACTEL_PROGRAM) + " devices --sensors > " + at + "out";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 0);
  std::istringstream lines(text_of(at + "out"));
  std::vector<std::string> all;
  for (std::string line; std::getline(lines, line);) all.push_back(line);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_THAT(all[0], ::testing::AllOf(HasSubstr("usb:glove "), HasSubstr("port 1-1 (serial number L-7)")));
  EXPECT_THAT(all[1], ::testing::AllOf(HasSubstr("usb:glove "), HasSubstr("port 1-2 (serial number R-8)")));
  EXPECT_THAT(all[2], ::testing::AllOf(HasSubstr("usb:1209:0001 "), HasSubstr("--profile"), HasSubstr("port 1-3")));
}

}  // namespace
}  // namespace tactel::hw::tests
