// SPDX-License-Identifier: Apache-2.0

// Regimes of the gap elements on a block of two surface nodes, a and b, whose stiffness is chosen so that all can be
// worked by hand:
//   node:  f_x = 2 u_x + u_y,  f_y = u_x + 4 u_y        (forces on the rubber; n = -f_y, t = f_x)
// With contact at depth d, u_y = -d:  t = 2 u_x - d,  n = 4 d - u_x.
#include "fem/gap/gap_increment.h"

#include <gtest/gtest.h>

#include <limits>

#include "fem/gap/gap_block.h"

namespace tactel::fem::gap_increment_test {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double exact = 1e-14;  // numbers of order 1 and a handful of operations

Mesh two_columns() {
  Mesh mesh{.element = Element::q4};
  mesh.node.resize(2, 4);
  mesh.node << 0, 1, 0, 1,  //
      0, 0, 1, 1;
  mesh.base = {0, 1};
  mesh.surface = {2, 3};
  return mesh;
}

// `free` [4, 4]: stiffness among a and b (a_x, a_y, b_x, b_y). The base node under each holds what keeps rigid
// translations free.
GapBlock make_block(const Eigen::Matrix4d& free) {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(8, 8);
  stiffness.bottomRightCorner(4, 4) = free;
  for (int node : {0, 2}) {
    const Eigen::Matrix2d total = free.block<2, 2>(node, 0) + free.block<2, 2>(node, 2);
    stiffness.block<2, 2>(4 + node, node) = -total;
    stiffness.block<2, 2>(node, 4 + node) = -total.transpose();
    stiffness.block<2, 2>(node, node) = total.transpose();
  }
  return {two_columns(), stiffness.sparseView()};
}

Eigen::Matrix4d separate_nodes() {
  Eigen::Matrix4d free = Eigen::Matrix4d::Zero();
  free.topLeftCorner<2, 2>() << 2, 1, 1, 4;
  free.bottomRightCorner<2, 2>() << 2, 1, 1, 4;
  return free;
}

// a and b drag each other: f_ax = 2 u_ax - u_bx, f_ay = 4 u_ay, and the same with a and b exchanged.
Eigen::Matrix4d dragging_nodes() {
  Eigen::Matrix4d free = Eigen::Vector4d(2, 4, 2, 4).asDiagonal();
  free(0, 2) = free(2, 0) = -1;
  return free;
}

class Contact {
 public:
  Contact(const Eigen::Matrix4d& free, double mu, double height_a, double height_b)
      : block_(make_block(free)),
        mu_(mu),
        height_(Eigen::Vector2d(height_a, height_b)),
        pose_(undeformed(block_, height_)) {}

  /// Goes on to depth and tangential position.
  const GapPose& move(double depth, double tangential) { return load({false, false, depth, tangential}); }
  const GapPose& load(const LoadStep& target) {
    const GapIncrement increment{block_, mu_, height_, target, pose_};
    answer_ = solve_increment(increment, 100, 1e-12);
    status_ = gap_status(elements_of(increment, answer_.pose));
    pose_ = answer_.pose;
    return pose_;
  }
  const GapAnswer& answer() const { return answer_; }
  GapStatus status(int node) const { return status_[node]; }

 private:
  GapBlock block_;
  double mu_;
  Eigen::VectorXd height_;
  GapPose pose_;
  GapAnswer answer_;
  std::vector<GapStatus> status_;
};

void expect_forces(const Contact& contact, int node, double n, double t) {
  EXPECT_TRUE(contact.answer().converged);
  EXPECT_NEAR(contact.answer().pose.normal_force[node], n, exact);
  EXPECT_NEAR(contact.answer().pose.tangential_force[node], t, exact);
}

TEST(GapRegimes, Open) {
  Contact contact(separate_nodes(), 0.5, 0, 1.5);
  contact.move(1, 0);
  EXPECT_EQ(contact.status(1), GapStatus::open);
  expect_forces(contact, 1, 0, 0);
  EXPECT_NEAR(contact.answer().pose.gap[1], 0.5, exact);  // 1.5 - 1
}

TEST(GapRegimes, Stick) {
  Contact contact(separate_nodes(), 0.5, 0, infinity);
  contact.move(1, 0);  // u_x = 0: t = -1, n = 4
  EXPECT_EQ(contact.status(0), GapStatus::stick);
  expect_forces(contact, 0, 4, -1);
  contact.move(1, 1);  // u_x = 1: t = 1, n = 3
  EXPECT_EQ(contact.status(0), GapStatus::stick);
  expect_forces(contact, 0, 3, 1);
}

TEST(GapRegimes, SlipToThePlusSide) {
  // mu 0.2 cannot hold t = -d under n = 4 d: 2 u - d = -0.2 (4 d - u), u = d / 9.
  Contact contact(separate_nodes(), 0.2, 0, infinity);
  contact.move(0.9, 0);
  EXPECT_EQ(contact.status(0), GapStatus::slip);
  expect_forces(contact, 0, 3.5, -0.7);
  EXPECT_NEAR(contact.answer().pose.slip[0], 0.1, exact);
}

TEST(GapRegimes, SlipToTheMinusSide) {
  Contact contact(separate_nodes(), 0.5, 0, infinity);
  contact.move(1, 0);
  contact.move(1, 2);  // sticks up to X = 1.2; then 2 u - 1 = 0.5 (4 - u), u = 1.2
  EXPECT_EQ(contact.status(0), GapStatus::slip);
  expect_forces(contact, 0, 2.8, 1.4);
  EXPECT_NEAR(contact.answer().pose.slip[0], -0.8, exact);  // left behind by the indenter
}

TEST(GapRegimes, ReversalSticksAndThenSlipsBack) {
  Contact contact(separate_nodes(), 0.5, 0, infinity);
  contact.move(1, 0);
  contact.move(1, 2);
  contact.move(1, 1);  // carried back by 1 from u = 1.2: t = 0.4 - 1, n = 4 - 0.2
  EXPECT_EQ(contact.status(0), GapStatus::stick);
  expect_forces(contact, 0, 3.8, -0.6);
  contact.move(1, -0.5);  // u = -1.3 would need t = -3.6, n = 5.3; 2 u - 1 = -0.5 (4 - u), u = -2/3
  EXPECT_EQ(contact.status(0), GapStatus::slip);
  expect_forces(contact, 0, 14.0 / 3, -7.0 / 3);
}

TEST(GapRegimes, WithoutFrictionTouchingMeansSlip) {
  Contact contact(separate_nodes(), 0, 0, infinity);
  contact.move(1, 0.3);  // t = 0: u = 0.5, n = 3.5 wherever the indenter is
  EXPECT_EQ(contact.status(0), GapStatus::slip);
  expect_forces(contact, 0, 3.5, 0);
}

TEST(GapRegimes, ANodeThatIsTouchedSticksWhereItWasBefore) {
  Contact contact(dragging_nodes(), 5, 0, 1.5);
  contact.move(1, 1);  // a sticks at u = 1 and drags b along to u = 0.5
  EXPECT_EQ(contact.status(1), GapStatus::open);
  expect_forces(contact, 0, 4, 1.5);
  contact.move(2, 1.2);  // b is touched: it goes 0.2 with the indenter from 0.5 on
  EXPECT_EQ(contact.status(1), GapStatus::stick);
  expect_forces(contact, 0, 8, 1.7);  // 2 * 1.2 - 0.7
  expect_forces(contact, 1, 2, 0.2);  // 2 * 0.7 - 1.2; 4 (2 - 1.5)
}

TEST(GapRegimes, LiftingOffLeavesNothingBehind) {
  Contact contact(separate_nodes(), 0.5, 0, infinity);
  contact.move(1, 0);
  contact.move(1, 2);
  contact.move(-0.5, 2);
  EXPECT_EQ(contact.status(0), GapStatus::open);
  expect_forces(contact, 0, 0, 0);
  EXPECT_EQ(double(contact.answer().pose.state.cwiseAbs().maxCoeff()), 0);
}

TEST(GapRegimes, GrazingIsNoViolation) {
  // At depth 1 node b is touched with n = 0 exactly.
  Contact contact(separate_nodes(), 0.5, 0, 1);
  contact.move(1, 0);
  EXPECT_EQ(contact.status(1), GapStatus::open);
  expect_forces(contact, 0, 4, -1);
  EXPECT_LE(contact.answer().iterations, 3);
}

TEST(GapForces, NormalForceFindsItsDepth) {
  Contact contact(separate_nodes(), 0.5, 0, infinity);
  contact.load({true, false, 4, 0});  // n = 4 d
  expect_forces(contact, 0, 4, -1);
  EXPECT_NEAR(contact.answer().pose.depth, 1, exact);
}

TEST(GapForces, BothForcesFindDepthAndPosition) {
  Contact contact(separate_nodes(), 0.5, 0, infinity);
  contact.load({true, true, 4, 1});  // 4 d - u = 4, 2 u - d = 1
  expect_forces(contact, 0, 4, 1);
  EXPECT_NEAR(contact.answer().pose.depth, 9.0 / 7, exact);
  EXPECT_NEAR(contact.answer().pose.tangential, 8.0 / 7, exact);
}

TEST(GapForces, SeveralNodesShareTheForce) {
  Contact contact(separate_nodes(), 0.5, 0, 0.5);
  contact.load({true, false, 6, 0});  // 4 d + 4 (d - 0.5) = 6
  EXPECT_NEAR(contact.answer().pose.depth, 1, exact);
  expect_forces(contact, 0, 4, -1);
  expect_forces(contact, 1, 2, -0.5);
}

TEST(GapForces, NoForceIsNoContact) {
  Contact contact(separate_nodes(), 0.5, 0.25, 1);
  contact.load({true, false, 0, 0});
  expect_forces(contact, 0, 0, 0);
  EXPECT_EQ(contact.answer().pose.depth, 0.25);  // about to touch
}

TEST(GapForces, MoreThanFrictionCanHoldIsNotConverged) {
  Contact contact(separate_nodes(), 0.5, 0, infinity);
  contact.load({true, true, 4, 1});
  contact.load({true, true, 4, 2.1});  // mu P = 2
  EXPECT_FALSE(contact.answer().converged);
  EXPECT_LE(contact.answer().iterations, 100);
  contact.load({true, true, 4, 1.9});  // the next increment goes on from the best state found
  expect_forces(contact, 0, 4, 1.9);
}

}  // namespace tactel::fem::gap_increment_test
