// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/load_stepping.h"

#include <gmock/gmock.h>

namespace tactel::fem::load_stepping_test {

using testing::ElementsAre;

/// Numbers of the steps that are kept of 2 targets in 2 steps, each in `parts`, and 3 drags.
std::vector<int> kept(int parts) {
  const Load load{.indentation = {0.1, 0.05}, .indentation_steps = 2, .tangential = {0.1, 0.2, 0.3}};
  ContactSolution solution;
  for (int k = 0; k < 4 * parts + 3; ++k) solution.steps.emplace_back().iterations = k;
  keep_own_steps(solution, load, parts);
  std::vector<int> numbers;
  for (const ContactStep& step : solution.steps) numbers.push_back(step.iterations);
  return numbers;
}

TEST(LoadStepping, KeepsTheStepsOfTheLoad) {
  EXPECT_THAT(kept(1), ElementsAre(0, 1, 2, 3, 4, 5, 6));
  EXPECT_THAT(kept(3), ElementsAre(2, 5, 8, 11, 12, 13, 14));
}

TEST(LoadStepping, PartsAreTheLeastThatSuffice) {
  const Load load{.indentation_steps = 3};
  EXPECT_EQ(pressing_parts(load, 1), 1);
  EXPECT_EQ(pressing_parts(load, 3), 1);
  EXPECT_EQ(pressing_parts(load, 4), 2);
  EXPECT_EQ(pressing_parts(load, 20), 7);
}

}  // namespace tactel::fem::load_stepping_test
