// SPDX-License-Identifier: Apache-2.0

// The slip index with torque: closed forms, invariance, and rigid sliding, which is the limit by definition.
#include "fem/pad/slip_margin.h"

#include <gtest/gtest.h>

#include <random>

namespace tactel::fem::slip_margin_test {

/// A disc of cells that all bear pressure, the same seen from opposite sides.
struct Disc {
  Eigen::MatrixX2d places;
  Eigen::VectorXd grip;
  Disc() : places(97, 2), grip(97) {
    int k = 0;
    for (int i = -5; i <= 5; ++i)
      for (int j = -5; j <= 5; ++j)
        if (i * i + j * j <= 30) {
          places.row(k) << 0.3 * i, 0.3 * j;
          grip[k++] = 0.4 * std::sqrt(31.0 - i * i - j * j);
        }
    places.conservativeResize(k, 2);
    grip.conservativeResize(k);
  }
};

struct Random {
  std::mt19937 engine{7};
  double operator()(double from, double to) { return std::uniform_real_distribution<double>(from, to)(engine); }
};

TEST(SlipMargin, OfAForceThroughTheCentreIsTheForceRatio) {
  const Disc disc;
  EXPECT_NEAR(slip_margin(disc.places, disc.grip, {1.2, 1.6, 0}), 2 / disc.grip.sum(), 1e-9);
}

TEST(SlipMargin, OfPureTorsionIsTheMomentRatio) {
  const Disc disc;
  const double most = disc.grip.dot(disc.places.rowwise().norm());
  EXPECT_NEAR(slip_margin(disc.places, disc.grip, {0, 0, 3}), 3 / most, 1e-7);
}

TEST(SlipMargin, IsOneWhereAllCellsSlideAsOneTwist) {
  const Disc disc;
  Random random;
  for (int k = 0; k < 200; ++k) {
    Eigen::VectorXd grip = disc.grip;
    for (double& g : grip) g *= random(0, 1);
    const Eigen::Vector2d v(random(-1, 1), random(-1, 1));
    const double w = random(-2, 2);
    Eigen::Vector3d wrench = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < grip.size(); ++i) {
      const Eigen::Vector2d r = disc.places.row(i), slip(v[0] - w * r[1], v[1] + w * r[0]),
                            t = grip[i] * slip.normalized();
      wrench += Eigen::Vector3d(t[0], t[1], r[0] * t[1] - r[1] * t[0]);
    }
    const double all = slip_margin(disc.places, grip, wrench), four = slip_margin(disc.places, grip, wrench, 4);
    EXPECT_NEAR(all, 1, 1e-6) << k;
    EXPECT_NEAR(four, 1, 2e-3) << k;
    EXPECT_LE(four, all + 1e-12) << k;  // each round is an upper bound on lambda
  }
}

TEST(SlipMargin, DoesNotDependOnThePointOfReference) {
  const Disc disc;
  const Eigen::Vector3d wrench(3, -2, 4);
  const Eigen::RowVector2d shift(7, -11);
  const Eigen::Vector3d seen(3, -2, 4 + shift[0] * -2 - shift[1] * 3);
  EXPECT_NEAR(slip_margin(disc.places.rowwise() + shift, disc.grip, seen), slip_margin(disc.places, disc.grip, wrench),
              1e-12);
}

TEST(SlipMargin, IsTheOptimumAmongTractions) {
  // Primal side: any tractions inside the cones whose wrench is along the one given are a lower bound on lambda; those
  // of the twist that the dual finds reach it. Two cells, where the answer is one line of algebra: a force F across the
  // line between two equal cells, at a quarter of their distance from the middle, loads one with 3 F / 4.
  Eigen::MatrixX2d places(2, 2);
  places << -1, 0, 1, 0;
  const Eigen::Vector2d grip(2, 2);
  EXPECT_NEAR(slip_margin(places, grip, {0, 1, 0.5}), 0.75 / 2, 1e-6);
}

TEST(SlipMargin, NothingToBear) {
  const Disc disc;
  EXPECT_EQ(slip_margin(disc.places, disc.grip, {0, 0, 0}), 0);
  EXPECT_EQ(slip_margin(disc.places, 0 * disc.grip, {1, 0, 0}), 0);
  EXPECT_NEAR(slip_margin(Eigen::MatrixX2d::Zero(1, 2), Eigen::VectorXd::Constant(1, 4), {2, 0, 0}), 0.5, 1e-9);
}

}  // namespace tactel::fem::slip_margin_test
