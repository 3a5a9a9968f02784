// SPDX-License-Identifier: Apache-2.0
#include "host/support/chosen_row.h"

#include <gtest/gtest.h>

#include <map>

namespace tactel::host::chosen_row_test {

TEST(ChosenRow, LiesInItsPart) {
  for (const std::uint64_t rows : {600u, 601u, 1199u, 27000u})
    for (std::uint64_t k = 0; k < 600; ++k) {
      EXPECT_GE(chosen_row(k, 600, rows), k * rows / 600);
      EXPECT_LT(chosen_row(k, 600, rows), (k + 1) * rows / 600);
    }
}

// Rows k n / 600 of 27 000 are all the first of their nine. A choice by chance takes 600 / 9 = 67 of each, and differs
// from it by four deviations, 4 sqrt(600 * 8 / 81) = 31, once in 16 000 times.
TEST(ChosenRow, KeepsNoStepOfAPeriod) {
  std::map<std::uint64_t, int> of_step;
  for (std::uint64_t k = 0; k < 600; ++k) ++of_step[chosen_row(k, 600, 27000) % 9];
  for (std::uint64_t step = 0; step < 9; ++step) EXPECT_NEAR(of_step[step], 600 / 9.0, 31) << step;
}

}  // namespace tactel::host::chosen_row_test
