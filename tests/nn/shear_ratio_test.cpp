// SPDX-License-Identifier: Apache-2.0

// The estimator without a network, on numbers worked by hand.
#include "nn/shear_ratio.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/numbers/value_error.h"

namespace tactel::nn::shear_ratio_test {

/// Two tactels. Ratios: (1 + 2) / (3 + 3) = 1/2, 4 / 4 = 1, -1 / 4, none, 0.
FrameSet five_rows() {
  FrameSet set;
  set.frames.resize(5, 4);
  set.frames << -3, -3, 1, 2,  //
      -4, 0, 4, 0,             //
      -2, 2, 0, -1,            //
      0, 0, 0, 0,              //
      -1, 0, 0, 0;
  set.slip_index.resize(5);
  set.slip_index << 0.5f, 0.75f, -0.5f, 0, 0;
  return set;
}

TEST(ShearRatio, IsShearOverNormalStress) {
  const std::vector<double> ratios = shear_ratios(five_rows());
  EXPECT_DOUBLE_EQ(ratios[0], 0.5);
  EXPECT_DOUBLE_EQ(ratios[1], 1);
  EXPECT_DOUBLE_EQ(ratios[2], -0.25);
  EXPECT_TRUE(std::isnan(ratios[3]));
  EXPECT_DOUBLE_EQ(ratios[4], 0);
}

// S / r of the rows with a ratio: 1, 3/4, 2; their median is 1. Least squares: (1/4 + 3/4 + 1/8) / (1/4 + 1 + 1/16).
TEST(ShearRatio, IsFittedByMedianAndByLeastSquares) {
  EXPECT_DOUBLE_EQ(fit_shear_ratio(five_rows(), RatioFit::median), 1);
  EXPECT_DOUBLE_EQ(fit_shear_ratio(five_rows(), RatioFit::least_squares), 1.125 / 1.3125);
}

TEST(ShearRatio, ErrorsAreOfTheFactorTimesTheRatio) {
  const std::vector<double> errors = shear_ratio_errors(five_rows(), 2);
  EXPECT_DOUBLE_EQ(errors[0], 0.5);
  EXPECT_DOUBLE_EQ(errors[1], 1.25);
  EXPECT_DOUBLE_EQ(errors[2], 0);
  EXPECT_TRUE(std::isnan(errors[3]));
}

TEST(ShearRatio, CannotBeFittedWithoutARatio) {
  FrameSet set = five_rows();
  set.frames.setZero();
  EXPECT_THROW(fit_shear_ratio(set, RatioFit::median), ValueError);
}

}  // namespace tactel::nn::shear_ratio_test
