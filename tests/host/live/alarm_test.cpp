// SPDX-License-Identifier: Apache-2.0
#include "host/live/alarm.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tactel::host {

// Begins at the threshold, holds down to 0.05 below it and over a frame without answer, and begins again at it alone.
TEST(Alarm, HasHysteresis) {
  Alarm alarm(0.8f);
  const float values[] = {0.5f, 0.79f, 0.8f, 0.76f, NAN, 0.751f, 0.74f, 0.79f, 1.0f, NAN, 0.1f};
  const bool on[] = {false, false, true, true, true, true, false, false, true, true, false};
  for (std::size_t i = 0; i < std::size(values); ++i) EXPECT_EQ(alarm.next(values[i]), on[i]) << i;
}

// Intervals of at most 0.4 begin an alarm; it goes on at wider ones. A wide one above the threshold cannot tell.
TEST(Alarm, AWideIntervalCannotTell) {
  Alarm alarm(0.8f, 0.4f);
  const float values[] = {0.9f, 0.9f, 0.9f, 0.7f, 0.9f, 0.5f, 0.9f};
  const float widths[] = {0.5f, 0.4f, 0.5f, 0.5f, NAN, 0.9f, 0.3f};
  const bool on[] = {false, true, true, false, false, false, true};
  const bool cannot_tell[] = {true, false, false, false, true, false, false};
  for (std::size_t i = 0; i < std::size(values); ++i) {
    EXPECT_EQ(alarm.next(values[i], widths[i]), on[i]) << i;
    EXPECT_EQ(alarm.cannot_tell(), cannot_tell[i]) << i;
  }
}

}  // namespace tactel::host
