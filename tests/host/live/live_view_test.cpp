#include "host/live/live_view.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

namespace tactel::host {
namespace {

using ::testing::HasSubstr;

/// Columns that a terminal needs for a line of UTF-8 whose characters are one wide each.
int width_of(const std::string& line) {
  return static_cast<int>(std::ranges::count_if(line, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::vector<std::string> view_lines(const std::vector<float>& stresses, float largest, int columns, float s = 0.5f) {
  std::istringstream in(
      view_text({.frame = {.number = 123456}, .stresses = stresses, .answer = {.slip_index = s}, .latency = 6}, largest,
                columns));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(LiveView, ShowsTheSignOfShear) {
  const auto lines = view_lines({-1, -0.5f, 0, 0, /* shear */ 1, -1, 0.5f, 0}, 1, 80);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[1], "normal |█▄  |");
  EXPECT_EQ(lines[2], "shear  |██▄ |");
  EXPECT_EQ(lines[3], "       |→←→ |");
}

TEST(LiveView, NoLineIsWiderThanTheTerminal) {
  std::vector<float> stresses(256, 0.1f);
  stresses[128 + 127] = -1;  // the last shear
  for (const int columns : {20, 21, 40, 79, 80, 137, 200})
    for (const float s : {0.5f, std::nanf("")})
      for (const std::string& line : view_lines(stresses, 1, columns, s)) EXPECT_LE(width_of(line), columns) << line;
  EXPECT_EQ(view_lines(stresses, 1, 29)[3], "       |→→→→→→→→→→→→→→→→→→→←|") << "the largest of neighbours is shown";
  EXPECT_EQ(width_of(view_lines(stresses, 1, 200)[1]), 128 + 9) << "one column a tactel where there is room";
}

TEST(LiveView, GoesUpOverThePictureBeforeOnATerminalAlone) {
  const std::vector<float> stresses(4, 0.1f);
  const MonitorLine line{.frame = {}, .stresses = stresses, .answer = {.slip_index = 0.5f}};
  LiveView on_terminal(true), in_file(false);
  EXPECT_THAT(*on_terminal.show(line, 80), ::testing::Not(HasSubstr("\x1b[5A")));
  EXPECT_THAT(*in_file.show(line, 80), ::testing::Not(HasSubstr("\x1b")));
  EXPECT_FALSE(in_file.show(line, 80)) << "the picture before is fresh";
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_THAT(*on_terminal.show(line, 80), ::testing::StartsWith("\x1b[5A"));
  EXPECT_THAT(*in_file.show(line, 80), ::testing::Not(HasSubstr("\x1b")));
}

}  // namespace
}  // namespace tactel::host
