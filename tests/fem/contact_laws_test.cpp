// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/contact_laws.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace tactel::fem::contact_laws_test {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double worst = std::numeric_limits<double>::max();

// Four elements that meet every law: no indenter, open, stick, slip against friction.
GapElements lawful() {
  return {.mu = 0.5,
          .gap = Eigen::VectorXd{{infinity, 0.2, 0, 0}},
          .slip = Eigen::VectorXd{{0.3, -0.3, 0, -0.1}},
          .normal_force = Eigen::VectorXd{{0, 0, 4, 2}},
          .tangential_force = Eigen::VectorXd{{0, 0, -1.5, 1}},
          .base_force = {-0.5, -6},
          .largest_displacement = 0.25};
}

TEST(ContactLaws, StatusFollowsFromForces) {
  const std::vector<GapStatus> expected{GapStatus::open, GapStatus::open, GapStatus::stick, GapStatus::slip};
  EXPECT_EQ(gap_status(lawful()), expected);
}

TEST(ContactLaws, WithoutFrictionTouchingNodesSlip) {
  GapElements e = lawful();
  e.mu = 0;
  e.tangential_force.setZero();
  const std::vector<GapStatus> expected{GapStatus::open, GapStatus::open, GapStatus::slip, GapStatus::slip};
  EXPECT_EQ(gap_status(e), expected);
}

TEST(ContactLaws, LawfulElementsHaveNoResidual) { EXPECT_EQ(largest(contact_residual(lawful())), 0); }

TEST(ContactLaws, PenetrationIsRelativeToTheDisplacement) {
  GapElements e = lawful();
  e.gap[1] = -0.01;
  EXPECT_DOUBLE_EQ(contact_residual(e).penetration, 0.04);  // 0.01 / 0.25
}

TEST(ContactLaws, ConeIsRelativeToTheLargestNormalForce) {
  GapElements e = lawful();
  e.tangential_force[3] = 1.2;
  e.base_force[0] = -0.3;
  EXPECT_DOUBLE_EQ(contact_residual(e).cone, 0.05);  // (1.2 - 0.5 * 2) / 4
  EXPECT_LT(contact_residual(e).balance, 1e-15);     // rounding of the sums
}

// n of the last element is 1e-13 of the largest: half of its limit of 4e-7 may be rounding of n.
TEST(ContactLaws, AtUnlimitedFrictionTheConeIsKnownToTheRoundingOfN) {
  GapElements e = lawful();
  e.mu = largest_friction;
  e.normal_force[3] = 4e-13;
  for (const double beyond : {2e-7, 8e-7}) {
    e.tangential_force[3] = 4e-7 + beyond;
    const double counted = beyond - 4e-7;  // solved_rounding mu 4
    EXPECT_NEAR(contact_residual(e).cone, std::max(0.0, counted / 4), 1e-15);
  }
}

TEST(ContactLaws, APullingNodeViolatesTheCone) {
  GapElements e = lawful();
  e.mu = 0;
  e.tangential_force.setZero();
  e.normal_force[1] = -1;
  EXPECT_DOUBLE_EQ(contact_residual(e).cone, 0.25);
}

TEST(ContactLaws, AGapUnderPressureViolatesComplementarity) {
  GapElements e = lawful();
  e.gap[2] = 0.005;
  EXPECT_DOUBLE_EQ(contact_residual(e).complementarity, 0.02);
}

TEST(ContactLaws, SlipOfAStickingNodeIsDrift) {
  GapElements e = lawful();
  e.slip[2] = 0.05;
  EXPECT_DOUBLE_EQ(contact_residual(e).drift, 0.2);
}

TEST(ContactLaws, SlipAlongFrictionIsDrift) {
  GapElements e = lawful();
  e.slip[3] = 0.1;  // friction on the rubber points to +x: it may only slip to -x
  EXPECT_DOUBLE_EQ(contact_residual(e).drift, 0.4);
}

TEST(ContactLaws, BalanceComparesBaseAndSurface) {
  GapElements e = lawful();
  e.base_force[1] = -5.4;  // 6 pressed in; the horizontal parts agree
  EXPECT_NEAR(contact_residual(e).balance, 0.6 / std::hypot(6, 0.5), 1e-15);  // rounding of one division
}

TEST(ContactLaws, NaNIsTheWorstResidual) {
  for (int place = 0; place < 4; ++place) {
    GapElements e = lawful();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    (place == 0 ? e.gap[0] : place == 1 ? e.slip[1] : place == 2 ? e.normal_force[2] : e.tangential_force[3]) = nan;
    EXPECT_EQ(largest(contact_residual(e)), worst) << place;
  }
}

TEST(ContactLaws, AViolationWithoutAScaleIsTheWorstResidual) {
  GapElements e = lawful();
  e.normal_force.setZero();
  e.tangential_force.setZero();
  e.base_force.setZero();
  e.largest_displacement = 0;
  EXPECT_EQ(largest(contact_residual(e)), 0);
  e.gap[1] = -1e-3;
  EXPECT_EQ(contact_residual(e).penetration, worst);
}

}  // namespace tactel::fem::contact_laws_test
