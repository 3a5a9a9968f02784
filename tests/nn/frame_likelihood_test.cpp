// SPDX-License-Identifier: Apache-2.0

// Densities of readings: by hand, by the full covariance matrix, and as numbers drawn from them.
#include "nn/frame_likelihood.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

#include "fem/value_error.h"

namespace tactel::nn {
namespace {

// One frame of two transducers, no gains: sigma = 0.5 max(|-2|, 1) = 1. Residuals 1 and -2: -(1 + 4) / 2 - 2 ln 1.
TEST(FrameLikelihood, OfOneFrameIsAGaussian) {
  const ReadingModel model{.inputs = 2, .history = 1, .noise = 0.5, .gain = 0};
  const std::vector<float> truth = {-2, 1}, reading = {-1, -1};
  EXPECT_DOUBLE_EQ(deviation(model, truth), 1);
  EXPECT_DOUBLE_EQ(log_likelihood(model, truth, reading), -2.5);
}

// Three frames of two transducers with gains: by the inverse and the determinant of the whole covariance matrix, which
// are taken in another way than those of the function.
TEST(FrameLikelihood, OfFramesWithGainsIsThatOfTheirCovariance) {
  const ReadingModel model{.inputs = 2, .history = 3, .noise = 0.1, .gain = 0.3};
  const std::vector<float> truth = {-2, 1, -1.5, 0.5, -1, 0}, reading = {-2.5f, 1.25f, -2, 0.5f, -1.25f, 0.125f};
  const double sigma = 0.1 * 2;
  Eigen::MatrixXd covariance = sigma * sigma * Eigen::MatrixXd::Identity(6, 6);
  Eigen::VectorXd residual(6);
  for (int i = 0; i < 6; ++i) {
    residual(i) = reading[i] - truth[i];
    for (int j = 0; j < 6; ++j)
      if (i % 2 == j % 2) covariance(i, j) += 0.09 * truth[i] * truth[j];
  }
  const double expected = -0.5 * (residual.dot(covariance.inverse() * residual) + std::log(covariance.determinant()));
  EXPECT_NEAR(log_likelihood(model, truth, reading), expected, 1e-12 * std::abs(expected));
}

// The mean of -2 log of the density of its own readings, less the determinant, is their number: a chi-square of 4
// degrees. 4000 of them: within 5 standard errors, sqrt(2 4 / 4000).
TEST(FrameLikelihood, DrawnReadingsHaveTheDensity) {
  const ReadingModel model{.inputs = 2, .history = 2, .noise = 0.1, .gain = 0.5};
  RowMatrix<float> truth(4000, 4);
  truth.rowwise() = Eigen::RowVector4f(-2, 1, -1.5f, 0.5f);
  const RowMatrix<float> readings = draw_readings(model, truth, 11);
  const std::span<const float> one(truth.data(), 4);
  const double at_truth = log_likelihood(model, one, one);  // the constant part
  double sum = 0;
  for (Eigen::Index row = 0; row < readings.rows(); ++row)
    sum -= 2 * (log_likelihood(model, one, {readings.row(row).data(), 4}) - at_truth);
  EXPECT_NEAR(sum / 4000, 4, 5 * std::sqrt(8.0 / 4000));
  EXPECT_EQ(draw_readings(model, truth, 11), readings);
}

// One unknown number, S itself over its range: sigma = 0.1 2 = 0.2, J = (0, 3), g = 1: variance 1 / (9 / 0.04 + 12) = 1
// / 237.
TEST(LinearError, OfOneNumberIsByHand) {
  const ReadingModel model{.inputs = 2, .history = 1, .noise = 0.1, .gain = 0};
  const std::vector<float> truth = {-2, 1};
  RowMatrix<double> j(2, 1);
  j << 0, 3;
  EXPECT_NEAR(linear_error(model, truth, j, Vector<double>::Ones(1)), std::sqrt(2 / std::numbers::pi / 237), 1e-9);
}

// Gains of two transducers in two frames, as unknown numbers of their own beside two others: the same error.
TEST(LinearError, TakesGainsAsUnknownNumbers) {
  const ReadingModel model{.inputs = 2, .history = 2, .noise = 0.1, .gain = 0.3};
  const std::vector<float> truth = {-2, 1, -1.5, 0.5};
  RowMatrix<double> j(4, 2);
  j << 1, 0.5, -0.25, 2, 0.75, 0, 1, 1;
  const Vector<double> g = Vector<double>::LinSpaced(2, 0.5, 1);
  Eigen::MatrixXd all(4, 4);
  all << j.row(0), 0.3 * -2, 0, j.row(1), 0, 0.3 * 1, j.row(2), 0.3 * -1.5, 0, j.row(3), 0, 0.3 * 0.5;
  Eigen::MatrixXd precision = all.transpose() * all / 0.04;
  precision.diagonal() += Eigen::Vector4d(12, 12, 1, 1);
  const Eigen::Vector4d of_all(g(0), g(1), 0, 0);
  const double expected = std::sqrt(2 / std::numbers::pi * of_all.dot(precision.inverse() * of_all));
  EXPECT_NEAR(linear_error(model, truth, j, g), expected, 1e-7 * expected);
}

// Noise over a stress of 4 MPa, the contact's: sigma = 0.5 4 = 2. Residuals 1 and -2: -(1 + 4) / (2 4) - 2 ln 2.
TEST(FrameLikelihood, NoiseIsOverTheContactsLargestStressWhereItIsGiven) {
  const ReadingModel model{.inputs = 2, .history = 1, .noise = 0.5, .gain = 0};
  const std::vector<float> truth = {-2, 1}, reading = {-1, -1};
  EXPECT_DOUBLE_EQ(log_likelihood(model, truth, reading, 4), -0.625 - 2 * std::log(2.0));
  RowMatrix<float> two(2, 2);
  two << -2, 1, -2, 1;
  const RowMatrix<float> own = draw_readings(model, two, 5);
  const RowMatrix<float> other = draw_readings(model, two, 5, std::vector<float>{2, 4});
  EXPECT_EQ(other.row(0), own.row(0));
  EXPECT_LT(((other - two).row(1) - 2 * (own - two).row(1)).cwiseAbs().maxCoeff(), 1e-6f);  // rounding
  RowMatrix<double> j(2, 1);
  j << 0, 3;
  EXPECT_NEAR(linear_error(model, truth, j, Vector<double>::Ones(1), 4),
              std::sqrt(2 / std::numbers::pi / (9.0 / 4 + 12)), 1e-9);
}

// A frame from before the contact has no reading: it stays zeros, and the others keep their bits.
TEST(FrameLikelihood, FramesBeforeTheContactStayZeros) {
  const ReadingModel model{.inputs = 2, .history = 3, .noise = 0.1, .gain = 0.5};
  const RowMatrix<float> truth{{-2, 1, 0, 0, -1, 0}}, whole{{-2, 1, -1, 1, -1, 0}};
  const RowMatrix<float> readings = draw_readings(model, truth, 7), others = draw_readings(model, whole, 7);
  EXPECT_EQ(readings.middleCols(2, 2), RowMatrix<float>::Zero(1, 2));
  EXPECT_EQ(readings.leftCols(2), others.leftCols(2));
  EXPECT_EQ(readings.rightCols(2), others.rightCols(2));
}

TEST(FrameLikelihood, RefusesModelsWithoutNoise) {
  EXPECT_THROW((ReadingModel{.inputs = 2, .noise = 0}.validate()), ValueError);
  EXPECT_THROW((ReadingModel{.inputs = 2, .noise = 0.1, .gain = -1}.validate()), ValueError);
  EXPECT_THROW((ReadingModel{.inputs = 2, .history = 0, .noise = 0.1}.validate()), ValueError);
}

}  // namespace
}  // namespace tactel::nn
