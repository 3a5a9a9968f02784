// SPDX-License-Identifier: Apache-2.0

// Items made on several threads, taken in order.
#include "host/support/made_ahead.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>

namespace tactel::host::made_ahead_test {

using namespace std::chrono_literals;

TEST(MadeAhead, ItemsComeInOrderForAnyNumberOfThreads) {
  for (const int threads : {0, 1, 5}) {
    const auto make = [](std::uint64_t k) {
      std::this_thread::sleep_for((k % 3) * 200us);  // later items are often done sooner
      return k * k;
    };
    MadeAhead<std::uint64_t> items(7, threads, 4, make);
    EXPECT_EQ(items.threads(), threads);
    for (std::uint64_t k = 7; k < 60; ++k) EXPECT_EQ(items.next(), k * k) << threads << " threads";
  }
}

TEST(MadeAhead, MakesNoMoreThanItMay) {
  std::atomic<std::uint64_t> begun = 0;
  MadeAhead<int> items(0, 4, 6, [&](std::uint64_t) { return ++begun, 1; });
  for (std::uint64_t taken = 0; taken < 20; ++taken) {
    std::this_thread::sleep_for(1ms);
    EXPECT_LE(begun, taken + 6);
    items.next();
  }
}

// The error belongs to its item: those before it are whole, and the end waits for nothing.
TEST(MadeAhead, AnErrorComesInItsTurn) {
  for (const int threads : {0, 3}) {
    MadeAhead<int> items(0, threads, 3, [](std::uint64_t k) {
      if (k == 5) throw std::runtime_error("item 5");
      return static_cast<int>(k);
    });
    for (int k = 0; k < 5; ++k) EXPECT_EQ(items.next(), k);
    EXPECT_THROW(items.next(), std::runtime_error);
  }
}

TEST(MadeAhead, EndsWithItemsUntaken) {
  std::atomic<int> under_way = 0;
  {
    const MadeAhead<int> items(0, 3, 8, [&](std::uint64_t) {
      ++under_way;
      std::this_thread::sleep_for(1ms);
      return --under_way;
    });
    std::this_thread::sleep_for(2ms);
  }
  EXPECT_EQ(under_way, 0);
}

}  // namespace tactel::host::made_ahead_test
