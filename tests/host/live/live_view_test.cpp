// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_view.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>
#include <tuple>

namespace tactel::host::live_view_test {

Answer answer_of(float slip_index) { return {.slip_index = slip_index}; }

using ::testing::HasSubstr;

/// Columns that a terminal needs for a line of UTF-8 whose characters are one wide each.
int width_of(const std::string& line) {
  return static_cast<int>(std::ranges::count_if(line, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::vector<std::string> view_lines(const std::vector<float>& stresses, float largest, int columns, float s = 0.5f) {
  std::istringstream in(view_text(
      {.frame = {.number = 123456}, .stresses = stresses, .answer = answer_of(s), .alarm = s >= 0.8f, .latency = 6}, {},
      largest, columns, {}));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// 29 columns: 20 for 4 tactels, 5 each.
TEST(LiveView, ShowsTheSignOfShearOverTheFullWidth) {
  const auto lines = view_lines({-1, -0.5f, 0, 0, /* shear */ 1, -1, 0.5f, 0}, 1, 29);
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[2], "normal |█████▄▄▄▄▄          |");
  EXPECT_EQ(lines[3], "shear  |██████████▄▄▄▄▄     |");
  EXPECT_EQ(lines[4], "       |→→→→→←←←←←→→→→→     |");
}

// 28 columns: a bar of 20, the alarm's mark at 16.
TEST(LiveView, MarksTheAlarmAndSaysIt) {
  EXPECT_EQ(view_lines({0.5f, 0}, 1, 28, 0.5f)[0], "S 0.500 ██████████······┊···");
  EXPECT_EQ(view_lines({0.5f, 0}, 1, 28, 0.9f)[0], "S 0.900 ██████████████████··");
  EXPECT_THAT(view_lines({0.5f, 0}, 1, 80, 0.79f)[5], ::testing::StartsWith("frame"));
  EXPECT_THAT(view_lines({0.5f, 0}, 1, 80, 0.8f)[5], ::testing::StartsWith("ALARM"));
}

TEST(LiveView, ColoursSWhereAsked) {
  const std::vector<float> stresses(4, 0.1f);
  const auto first = [&](float s) {
    return view_text({.frame = {}, .stresses = stresses, .answer = answer_of(s), .acted_on = s}, {}, 1, 80,
                     {.colour = true})
        .substr(0, 7);
  };
  EXPECT_EQ(first(0.5f), "\x1b[1;32m");
  EXPECT_EQ(first(0.7f), "\x1b[1;33m");
  EXPECT_EQ(first(0.9f), "\x1b[1;31m");
  EXPECT_EQ(first(std::nanf("")), "S   -  ");
}

TEST(SlipTrace, KeepsTheLargestOfEachQuarterSecondAndShowsGaps) {
  SlipTrace history;
  for (const auto& [at, s] : {std::pair{10.0, 0.1f}, {10.1, 0.9f}, {10.2, 0.2f}, {10.8, 0.3f}, {10.9, std::nanf("")}})
    history.add(at, s, 4);
  const auto& kept = history.columns();
  ASSERT_EQ(kept.size(), 4u);
  EXPECT_EQ(kept[0], 0.9f);
  EXPECT_TRUE(std::isnan(kept[1]) && std::isnan(kept[2])) << "no frame came in half a second";
  EXPECT_EQ(kept[3], 0.3f);
  history.add(11.0, 0.4f, 4);
  EXPECT_EQ(kept.size(), 4u);
  EXPECT_EQ(kept[3], 0.4f);
  history.add(1e9, 0.5f, 4);  // years later
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0], 0.5f);
}

TEST(LiveView, NoLineIsWiderThanTheTerminal) {
  std::vector<float> stresses(256, 0.1f);
  stresses[128 + 127] = -1;  // the last shear
  for (const int columns : {20, 21, 40, 79, 80, 137, 200})
    for (const float s : {0.5f, std::nanf("")})
      for (const std::string& line : view_lines(stresses, 1, columns, s)) EXPECT_LE(width_of(line), columns) << line;
  EXPECT_EQ(view_lines(stresses, 1, 29)[4], "       |→→→→→→→→→→→→→→→→→→→←|") << "the largest of neighbours is shown";
  EXPECT_EQ(width_of(view_lines(stresses, 1, 200)[2]), 128 + 9) << "one column a tactel where there is room";
}

TEST(LiveView, GoesUpOverThePictureBeforeOnATerminalAlone) {
  const std::vector<float> stresses(4, 0.1f);
  const MonitorLine line{.frame = {}, .stresses = stresses, .answer = answer_of(0.5f)};
  LiveView on_terminal({.cursor = true}), in_file({});
  EXPECT_THAT(*on_terminal.show(line, 80), ::testing::Not(HasSubstr("\x1b[6A")));
  EXPECT_THAT(*in_file.show(line, 80), ::testing::Not(HasSubstr("\x1b")));
  EXPECT_FALSE(in_file.show(line, 80)) << "the picture before is fresh";
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_THAT(*on_terminal.show(line, 80), ::testing::StartsWith("\x1b[6A"));
  EXPECT_THAT(*in_file.show(line, 80), ::testing::Not(HasSubstr("\x1b")));
}

TEST(LiveView, ShowsTheNewestFrameOnceWhereItCameTooSoon) {
  LiveView view({});
  std::vector<float> stresses(4, 0.1f);
  const auto show = [&](std::uint64_t number) {
    return view.show({.frame = {.number = number}, .stresses = stresses, .answer = answer_of(0.5f)}, 80);
  };
  EXPECT_FALSE(view.show_newest(80));
  EXPECT_TRUE(show(1));
  EXPECT_FALSE(view.show_newest(80)) << "is shown";
  EXPECT_FALSE(show(2));
  EXPECT_FALSE(show(3));
  stresses.assign(4, 0.0f);  // the caller's memory is used again
  const auto newest = view.show_newest(80);
  ASSERT_TRUE(newest);
  EXPECT_THAT(*newest, HasSubstr("frame 3"));
  EXPECT_THAT(*newest, HasSubstr("████")) << "of the frame's own stresses";
  EXPECT_FALSE(view.show_newest(80));
}

/// The tiles of two tactels beside each other, and of one above them. y points upwards.
std::string tiles_text(const std::vector<float>& stresses, std::vector<PadLayout> pads, int columns,
                       const std::vector<AlarmAnswer>& answers = {}) {
  const std::string text = view_text({.frame = {}, .stresses = stresses, .answer = answer_of(0.5f), .pads = answers},
                                     {}, 1, columns, {.pads = std::move(pads)});
  const std::size_t begin = text.find('\n', text.find('\n') + 1) + 1, end = text.rfind('\n', text.size() - 2) + 1;
  return text.substr(begin, end - begin);
}

// Shares of a full block: 1 and 0.5 below, 0 and 0.25 above. Arrows: 0.25 to +x, 0.1 to +y; below that none.
TEST(LiveView, APadIsTilesWithArrowsOfShear) {
  EXPECT_EQ(tiles_text({-1, -0.5f, 0, -0.25f, /* x */ 0.25f, 0, 0, 0.05f, /* y */ 0, 0.1f, 0, 0}, {{{2, 2}}}, 40),
            "····· ░░░░░ \n"
            "····· ░░░░░ \n"
            "█████ ▒▒▒▒▒ \n"
            "██⇒██ ▒▒↑▒▒ \n");
}

TEST(LiveView, ArrowsHaveEightDirections) {
  for (const auto& [x, y, arrow] : {std::tuple{1.f, 0.f, "⇒"},
                                    {1.f, 1.f, "⇗"},
                                    {0.f, 1.f, "⇑"},
                                    {-1.f, 1.f, "⇖"},
                                    {-1.f, 0.f, "⇐"},
                                    {-1.f, -1.f, "⇙"},
                                    {0.f, -1.f, "⇓"},
                                    {1.f, -1.f, "⇘"},
                                    {1.f, -0.4f, "⇒"},
                                    {1.f, -0.5f, "⇘"}})  // 22.5 degrees are between: tan is 0.414
    EXPECT_EQ(tiles_text({0, x, y}, {{{1, 1}}}, 40), fmt::format("····· \n··{}·· \n", arrow)) << x << " " << y;
}

TEST(LiveView, PadsStandSideBySideWithTheirSWhereTheyFit) {
  const std::vector<float> stresses{-1, 0, 0, /* second */ 0, -1};
  const std::vector<PadLayout> pads{{{2, 1}}, {{1, 3}}};
  const std::vector<AlarmAnswer> answers{{.answer = answer_of(0.25f)}, {.answer = answer_of(std::nanf(""))}};
  EXPECT_EQ(tiles_text(stresses, pads, 40, answers),
            "S 0.250        S   -  \n"
            "█████ ·····    █████ \n"
            "█████ ·····    █████ \n"
            "               ····· \n"
            "               ····· \n"
            "               ····· \n"
            "               ····· \n");
  const std::vector<PadLayout> wide{{{9, 1}}, {{9, 1}}};
  EXPECT_EQ(tiles_text(std::vector<float>(18, 0.0f), wide, 20, answers),
            "S 0.250\n··················\n··················\nS   -  \n··················\n··················\n");
}

TEST(LiveView, NoLineOfAPadIsWiderThanTheTerminal) {
  const std::vector<float> stresses(3 * 128, -0.5f);
  for (const std::vector<PadLayout>& pads :
       {std::vector<PadLayout>{{{128, 1}}}, {{{16, 4}}, {{16, 4}}}, {{{120, 1}}, {{8, 1}}}, {{{4, 24}}, {{4, 8}}}})
    for (const int columns : {20, 21, 40, 79, 80, 137, 200}) {
      std::istringstream in(tiles_text(stresses, pads, columns, std::vector<AlarmAnswer>(pads.size())));
      for (std::string line; std::getline(in, line);) EXPECT_LE(width_of(line), columns) << line;
    }
}

TEST(LiveView, GoesUpOverAsManyLinesAsThePadHad) {
  const std::vector<float> stresses(48, 0.1f);
  LiveView view({.cursor = true, .pads = {{{4, 4}}}});
  const MonitorLine line{.frame = {}, .stresses = stresses, .answer = answer_of(0.5f)};
  ASSERT_TRUE(view.show(line, 80));
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_THAT(*view.show(line, 80), ::testing::StartsWith("\x1b[11A")) << "S, history, 4 times 2, words";
}

}  // namespace tactel::host::live_view_test
