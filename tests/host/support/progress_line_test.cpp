// SPDX-License-Identifier: Apache-2.0
#include "host/support/progress_line.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace tactel::host::progress_line_test {

using testing::HasSubstr;
using testing::MatchesRegex;

constexpr ProgressTimes soon{.first = 0.05, .every = 0.2, .again = 0.2};

void wait(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

/// What `job` writes to stderr, which is no terminal here.
template <class Job>
std::string said(Job&& job) {
  testing::internal::CaptureStderr();
  job();
  return testing::internal::GetCapturedStderr();
}

long lines(const std::string& text) { return std::ranges::count(text, '\n'); }

TEST(ProgressLine, QuickJobSaysNothing) {
  EXPECT_EQ(said([] {
              ProgressLine line("job", "things", false);
              line.show(1, 2);
            }),
            "");
}

TEST(ProgressLine, LogGetsRateAndTimeLeft) {
  const std::string text = said([] {
    ProgressLine line("job", "things", false, 1000, soon);
    line.show(0, 100);
    wait(0.02);
    line.show(25, 100);
    wait(0.06);
  });
  EXPECT_THAT(text, MatchesRegex("job: 25\\.0 %, [0-9.]+ [kM] things/s, [0-9]+ s left\n"));
}

TEST(ProgressLine, LogGetsALineEachHalfMinute) {
  const std::string text = said([] {
    ProgressLine line("job", "things", false, 1, soon);
    for (std::size_t i = 0; i < 100; ++i) line.show(i, 100), wait(0.005);
  });
  EXPECT_GE(lines(text), 2);  // 0.05 and 0.25 s; a loaded machine takes longer
  EXPECT_LT(lines(text), 50);
}

TEST(ProgressLine, JobThatCountsNothingIsSaid) {
  const std::string text = said([] {
    StageLine line("solving scene.toml", false, {.first = 0.05, .every = 60, .again = 60});
    wait(0.5);  // a loaded machine takes longer
  });
  EXPECT_EQ(text, "solving scene.toml ...\n");
}

TEST(ProgressLine, QuietSaysNothing) {
  EXPECT_EQ(said([] {
              ProgressLine line("job", "things", true, 1, soon);
              line.show(1, 2);
              wait(0.1);
            }),
            "");
}

TEST(ProgressLine, SaysNothingAfterClear) {
  EXPECT_EQ(said([] {
              ProgressLine line("job", "things", false, 1, soon);
              line.show(1, 2);
              line.clear();
              wait(0.1);
            }),
            "");
}

TEST(ProgressLine, TheLatestSpeaks) {
  const std::string text = said([] {
    StageLine outer("outer", false, soon);
    StageLine inner("inner", false, soon);
    wait(0.1);
  });
  EXPECT_EQ(text, "inner ...\n");
}

TEST(ProgressLine, EarlierOneGoesOnAfterTheLatest) {
  const std::string text = said([] {
    StageLine outer("outer", false, soon);
    { StageLine inner("inner", false, soon); }
    wait(0.1);
  });
  EXPECT_EQ(text, "outer ...\n");
}

// What was done before a resume is no part of the rate: 10 in some 0.1 s.
TEST(ProgressLine, RateLeavesOutWhatWasDoneBefore) {
  const std::string text = said([] {
    ProgressLine line("job", "things", false, 1, {.first = 0.15, .every = 10, .again = 10});
    line.show(980, 1000);
    wait(0.1);
    line.show(990, 1000);
    wait(0.1);
  });
  EXPECT_THAT(text, HasSubstr("job: 99.0 %"));
  EXPECT_THAT(text, HasSubstr(" things/s"));
  EXPECT_THAT(text, testing::Not(HasSubstr(" k things/s")));  // some 100, not 9900
}

}  // namespace tactel::host::progress_line_test
