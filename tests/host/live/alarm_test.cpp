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

}  // namespace tactel::host
