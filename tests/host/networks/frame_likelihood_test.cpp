// SPDX-License-Identifier: Apache-2.0

// The kernel against its twin, and rows and readings alone against the same in a batch.
#include "host/networks/frame_likelihood.h"

#include <gtest/gtest.h>

#include "fem/value_error.h"
#include "tests/host/networks/network_cases.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using tactel::testing::bumps;
using tactel::testing::executor;

nn::RowMatrix<float> frames_of(const nn::ReadingModel& model, int rows) {
  nn::RowMatrix<float> frames = bumps(rows, model.size(), 4).frames;
  return frames.array() + 0.01f;  // each newest frame has stress
}

class FrameLikelihoodModel : public ::testing::TestWithParam<nn::ReadingModel> {};

// Every term is a square or positive: sums are right to some tens of roundings, 1e-5 in fp32. The logarithms of the
// constant are of the size 100. The twin takes a difference, and loses up to (gain f / sigma)^2, 1e7 here, of 1e-16.
TEST_P(FrameLikelihoodModel, MatchesItsTwin) {
  const nn::ReadingModel model = GetParam();
  const nn::RowMatrix<float> bank = frames_of(model, 75);
  const nn::RowMatrix<float> readings = nn::draw_readings(model, bank.topRows(21), 3);
  const auto fp64 = FrameLikelihood<double>(executor(), model, bank)(readings);
  const auto fp32 = FrameLikelihood<float>(executor(), model, bank)(readings);
  ASSERT_EQ(fp64.rows(), 21);
  ASSERT_EQ(fp64.cols(), 75);
  const auto size = static_cast<std::size_t>(model.size());
  for (Eigen::Index k = 0; k < 21; ++k)
    for (Eigen::Index row = 0; row < 75; ++row) {
      const double twin = nn::log_likelihood(model, {bank.row(row).data(), size}, {readings.row(k).data(), size});
      EXPECT_NEAR(fp64(k, row), twin, 1e-12 * std::abs(twin) + 1e-8) << k << ' ' << row;
      EXPECT_NEAR(fp32(k, row), twin, 1e-5 * std::abs(twin) + 1e-3) << k << ' ' << row;
    }
}

INSTANTIATE_TEST_SUITE_P(Models, FrameLikelihoodModel,
                         ::testing::Values(nn::ReadingModel{.inputs = 42, .history = 1, .noise = 0.01, .gain = 0},
                                           nn::ReadingModel{.inputs = 42, .history = 1, .noise = 0.01, .gain = 0.2},
                                           nn::ReadingModel{.inputs = 6, .history = 4, .noise = 0.001, .gain = 0.05},
                                           nn::ReadingModel{.inputs = 2, .history = 1, .noise = 1, .gain = 0}));

TEST(FrameLikelihood, DependsOnRowAndReadingAlone) {
  const nn::ReadingModel model{.inputs = 10, .history = 2, .noise = 0.01, .gain = 0.1};
  const nn::RowMatrix<float> bank = frames_of(model, 300);
  const nn::RowMatrix<float> readings = nn::draw_readings(model, bank.topRows(19), 3);
  const auto all = FrameLikelihood<float>(executor(), model, bank)(readings);
  const auto alone = FrameLikelihood<float>(executor(), model, bank.middleRows(257, 1))(readings.middleRows(17, 1));
  EXPECT_EQ(alone(0, 0), all(17, 257));
}

TEST(FrameLikelihood, RefusesRowsWithoutStress) {
  const nn::ReadingModel model{.inputs = 10, .history = 1, .noise = 0.01};
  nn::RowMatrix<float> bank = frames_of(model, 3);
  EXPECT_THROW(FrameLikelihood<float>(executor(), model, bank.leftCols(9).eval()), ValueError);
  bank.row(1).setZero();
  EXPECT_THROW(FrameLikelihood<float>(executor(), model, bank), ValueError);
}

}  // namespace
