// SPDX-License-Identifier: Apache-2.0
#include "host/contact/strata.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace tactel::host::strata_test {

TEST(Strata, AreOfEqualSizeInAscendingOrder) {
  const std::vector<double> friction = {0.9, 0.1, 0.5, 0.3, 0.7, 0.5};
  EXPECT_EQ(strata(friction, 3), (std::vector<int>{2, 0, 1, 0, 2, 1}));
}

TEST(Strata, DifferByOneWhereNumbersAreNoMultiple) {
  EXPECT_EQ(strata(std::vector<double>{1, 2, 3, 4, 5}, 2), (std::vector<int>{0, 0, 0, 1, 1}));
}

TEST(Strata, TakeEqualNumbersInTheirOrderAndNaNFirst) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(strata(std::vector<double>{1, 1, -5, nan}, 4), (std::vector<int>{2, 3, 1, 0}));
}

TEST(Strata, OfNothingAreNone) { EXPECT_TRUE(strata({}, 4).empty()); }

}  // namespace tactel::host::strata_test
