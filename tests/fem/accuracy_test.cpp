// SPDX-License-Identifier: Apache-2.0

// The rule of acceptance, worked by hand.
#include "fem/gap/accuracy.h"

#include <gtest/gtest.h>

namespace tactel::fem::accuracy_test {

TEST(Accuracy, FollowsFromTheToleranceOfTheSweeps) {
  EXPECT_DOUBLE_EQ((by_rule<float>({1e-5}, slow_on_mesh).accept), 1e-3);
  EXPECT_DOUBLE_EQ((by_rule<double>({1e-11}, slow_on_mesh).accept), 1e-9);
  EXPECT_DOUBLE_EQ((by_rule<float>({1e-3}, slow_on_patch).accept), 0.02);
  EXPECT_EQ((by_rule<float>({1e-3}, slow_on_patch).tolerance), 1e-3);
  // What a hundred times the tolerance, or the rounding of 2^-23, would make of others.
  EXPECT_EQ((by_rule<float>({1e-2}, slow_on_mesh).accept), 0.02);
  EXPECT_EQ((by_rule<double>({1e-7}, slow_on_mesh).accept), 1e-6);
  EXPECT_DOUBLE_EQ((by_rule<float>({1e-9}, slow_on_mesh).accept), 200 * 0x1p-23);
  // In fp64 the sweeps of a rung in fp32 go on.
  EXPECT_EQ((by_rule<double>({1e-3}, slow_on_patch).tolerance), 1e-7);
  EXPECT_EQ((by_rule<double>({1e-3}, slow_on_patch).accept), 1e-6);
}

TEST(Accuracy, ARequestedResidualIsAccepted) {
  EXPECT_EQ((by_rule<float>({0, 1e-2}, slow_on_mesh).accept), 1e-2);
  EXPECT_DOUBLE_EQ((by_rule<float>({0, 1e-2}, slow_on_mesh).tolerance), 1e-4);
  EXPECT_DOUBLE_EQ((by_rule<double>({0, 1e-2}, slow_on_patch).tolerance), 5e-4);
}

}  // namespace tactel::fem::accuracy_test
