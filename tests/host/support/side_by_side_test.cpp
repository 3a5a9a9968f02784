// SPDX-License-Identifier: Apache-2.0

// One call for each number, whatever the number of threads; the first error comes out.
#include "host/support/side_by_side.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "host/support/stop_scope.h"

namespace tactel::host::side_by_side_test {

TEST(SideBySide, CallsEachNumberOnce) {
  for (const int threads : {0, 1, 3, 100}) {
    std::vector<std::atomic<int>> calls(17);
    side_by_side(calls.size(), threads, [&](std::size_t k) { ++calls[k]; });
    for (const auto& count : calls) EXPECT_EQ(count, 1) << threads << " threads";
  }
  side_by_side(0, 4, [](std::size_t) { FAIL() << "nothing to do"; });
}

TEST(SideBySide, ThrowsTheErrorAndStops) {
  std::atomic<int> calls = 0;
  EXPECT_THROW(side_by_side(100000, 2,
                            [&](std::size_t k) {
                              ++calls;
                              if (k == 5) throw std::runtime_error("the sixth");
                            }),
               std::runtime_error);
  EXPECT_LT(calls, 100000);
}

// Also of the threads that help.
TEST(SideBySide, StopsWhereTheCallerIsToStop) {
  for (const int threads : {1, 3}) {
    std::atomic<int> calls = 0;
    const StopScope::Asked asked = [&] { return calls >= 5; };
    const StopScope scope(&asked);
    EXPECT_THROW(side_by_side(100000, threads, [&](std::size_t) { ++calls; }), Stopped);
    EXPECT_LT(calls, 5 + threads);
  }
}

}  // namespace tactel::host::side_by_side_test
