// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/banded_lu.h"

#include <gtest/gtest.h>

#include <random>

namespace tactel::fem::banded_lu_test {

struct Case {
  int size, band;
};

class BandedLuTest : public testing::TestWithParam<Case> {};

// Random entries: without row exchanges most of these matrices would lose many digits.
TEST_P(BandedLuTest, AgreesWithADenseSolve) {
  const auto [size, band] = GetParam();
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  BandedLu banded(size, band);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = std::max(0, i - band); j < std::min(size, i + band + 1); ++j) {
      banded.entry(i, j) = dense(i, j) = uniform(generator);
    }
  }
  const RowMatrix right = RowMatrix::NullaryExpr(size, 3, [&] { return uniform(generator); });
  RowMatrix solution = right;
  ASSERT_TRUE(banded.factor());
  banded.solve(solution);
  // Backward stable: the residual is rounding of |A| |x|; growth of the pivots is allowed a factor 1000.
  const double rounding =
      1000 * std::numeric_limits<double>::epsilon() * (dense.cwiseAbs() * solution.cwiseAbs()).maxCoeff();
  EXPECT_LT((dense * solution - right).cwiseAbs().maxCoeff(), rounding);
}

INSTANTIATE_TEST_SUITE_P(Sizes, BandedLuTest,
                         testing::Values(Case{1, 1}, Case{2, 1}, Case{7, 2}, Case{50, 3}, Case{200, 17}, Case{20, 19}));

TEST(BandedLu, ExchangesRowsWhereTheDiagonalIsZero) {
  BandedLu matrix(2, 1);  // x2 = 3, x1 = 5
  matrix.entry(0, 1) = 1;
  matrix.entry(1, 0) = 1;
  RowMatrix side(2, 1);
  side << 3, 5;
  ASSERT_TRUE(matrix.factor());
  matrix.solve(side);
  EXPECT_EQ(side(0), 5);
  EXPECT_EQ(side(1), 3);
}

TEST(BandedLu, SaysThatAMatrixIsSingular) {
  BandedLu matrix(3, 2);  // the third row is the sum of the others
  const double rows[3][3] = {{1, 2, 3}, {4, 5, 7}, {5, 7, 10}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) matrix.entry(i, j) = rows[i][j];
  EXPECT_FALSE(matrix.factor());
}

}  // namespace tactel::fem::banded_lu_test
