// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/last_used.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace tactel::fem::last_used_test {

TEST(LastUsed, KeepsTheLastOnesUsed) {
  LastUsed<int, int> squares(2);
  int made = 0;
  const auto square = [&](int key) { return squares.get(key, [&] { return ++made, key * key; }); };
  EXPECT_EQ(square(3), 9);
  EXPECT_EQ(square(4), 16);
  EXPECT_EQ(square(3), 9);  // now used later than 4
  EXPECT_EQ(made, 2);
  EXPECT_EQ(square(5), 25);
  EXPECT_EQ(squares.find(4), 0);
  EXPECT_EQ(squares.find(3), 9);
  EXPECT_EQ(made, 3);
}

TEST(LastUsed, KeepsNothingOfWhatFails) {
  LastUsed<int, int> all(2);
  EXPECT_THROW(all.get(1, []() -> int { throw std::runtime_error("no value"); }), std::runtime_error);
  EXPECT_EQ(all.get(1, [] { return 7; }), 7);
}

TEST(LastUsed, KeepsMoreOnRequest) {
  LastUsed<int, int> all(1);
  all.keep_at_least(3);
  for (const int key : {1, 2, 3}) all.get(key, [&] { return key; });
  for (const int key : {1, 2, 3}) EXPECT_EQ(all.find(key), key);
}

}  // namespace tactel::fem::last_used_test
