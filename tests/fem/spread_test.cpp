#include "fem/spread.h"

#include <gtest/gtest.h>

#include "fem/mesh.h"

namespace tactel::fem {
namespace {

Sensor small_sensor() {
  Sensor sensor;
  sensor.columns = 13;
  sensor.rows = 4;
  return sensor;
}

TEST(Spread, WeightsOfThreeColumnsByHand) {
  // Two gap elements on three columns: hats 1, 1/2, 0, times the width of each column (half at the ends), over their
  // sum.
  Eigen::MatrixXd expected(3, 2);
  expected << 0.5, 0, 0.5, 0.5, 0, 0.5;
  EXPECT_TRUE(spread_weights(3, 2).isApprox(expected, 1e-15));
}

TEST(Spread, InnerHatOfTwoColumnsByHand) {
  const Eigen::VectorXd inner = spread_weights(9, 2).col(2);
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(9);
  expected.segment(3, 3) << 0.25, 0.5, 0.25;
  EXPECT_TRUE(inner.isApprox(expected, 1e-15));
}

TEST(Spread, OneColumnToAnElementChangesNothing) {
  const Condensation block = condense(small_sensor());
  EXPECT_EQ(spread(block, 1).compliance, block.compliance);
}

TEST(Spread, KeepsSymmetryForceAndPlaces) {
  const Condensation block = condense(small_sensor()), coarse = spread(block, 3);
  ASSERT_EQ(coarse.surface_x.size(), 5);
  EXPECT_EQ(coarse.surface_x[1], block.surface_x[3]);
  EXPECT_EQ(coarse.compliance, coarse.compliance.transpose());
  EXPECT_GT(coarse.compliance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
  // A unit force on a gap element arrives at the base as a whole; condense() allows a loss of 1e-7.
  for (Eigen::Index j = 0; j < coarse.base_force.cols(); ++j)
    EXPECT_NEAR(coarse.base_force.col(j)(Eigen::seq(j % 2, Eigen::last, 2)).sum(), 1, 1e-7);
}

TEST(Spread, RefusesColumnsThatDoNotDivide) {
  EXPECT_THROW(spread_weights(12, 2), std::invalid_argument);
  EXPECT_THROW(spread_weights(13, 0), std::invalid_argument);
}

}  // namespace
}  // namespace tactel::fem
