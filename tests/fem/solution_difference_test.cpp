// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/solution_difference.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tactel::fem::solution_difference_test {

ContactSolution with_forces(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const ContactStep step{.base_force_x = x, .base_force_y = y};
  return {{}, {}, {}, {step}, false};
}

TEST(SolutionDifference, IsRelativeToTheLargestForceOfTheSecond) {
  const ContactSolution a = with_forces(Eigen::Vector2d(1, 2), Eigen::Vector2d(-3, -8.5));
  const ContactSolution b = with_forces(Eigen::Vector2d(1, 3), Eigen::Vector2d(-3, -8));
  EXPECT_DOUBLE_EQ(base_force_difference(a, b), 0.125);  // 1 of 8
}

TEST(SolutionDifference, NaNIsNotPassedOver) {
  ContactSolution a = with_forces(Eigen::Vector2d(1, NAN), Eigen::Vector2d(-3, -8));
  const ContactSolution b = with_forces(Eigen::Vector2d(1, 3), Eigen::Vector2d(-3, -8));
  EXPECT_TRUE(std::isnan(base_force_difference(a, b)));
  EXPECT_TRUE(std::isnan(base_force_difference(b, a)));
  a.steps.push_back(b.steps[0]);  // a later step that agrees does not hide it
  ContactSolution c = b;
  c.steps.push_back(b.steps[0]);
  EXPECT_TRUE(std::isnan(base_force_difference(a, c)));
}

TEST(SolutionDifference, ForcesBesideNoneAreInfinitelyOff) {
  const ContactSolution none = with_forces(Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0));
  const ContactSolution tiny = with_forces(Eigen::Vector2d(0, 1e-300), Eigen::Vector2d(0, 0));
  EXPECT_EQ(base_force_difference(none, none), 0);
  EXPECT_TRUE(std::isinf(base_force_difference(tiny, none)));
}

TEST(SolutionDifference, StepsAndNodesMustMatch) {
  const ContactSolution two = with_forces(Eigen::Vector2d(1, 2), Eigen::Vector2d(1, 2));
  const ContactSolution three = with_forces(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(std::isinf(base_force_difference(two, three)));
  EXPECT_TRUE(std::isinf(base_force_difference(two, ContactSolution{})));
}

}  // namespace tactel::fem::solution_difference_test
