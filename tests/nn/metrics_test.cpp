// SPDX-License-Identifier: Apache-2.0
#include "nn/metrics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/numbers/value_error.h"

namespace metrics_test {

using namespace tactel;
using namespace tactel::nn;

// S = 0.6 of which |Q| / (mu P) = 0.45 is a force alone: a quarter is torque. |Q| / (mu P) exceeds S by rounding alone.
TEST(TorqueClass, IsThirdsOfWhatTheForceDoesNotExplain) {
  EXPECT_EQ(torque_class(0.6f, 0.45f), 1);
  EXPECT_EQ(torque_class(0.6f, 0.3f), 2);
  EXPECT_EQ(torque_class(0.6f, 0.1f), 3);
  EXPECT_EQ(torque_class(0.6f, 0.6001f), 1);
  EXPECT_EQ(torque_class(1.0f, 0.0f), 3);
  EXPECT_EQ(torque_class(0.049f, 0.0f), 0);
  EXPECT_STREQ(torque_class_name(2), "torque 1/3 to 2/3");
}

TEST(Metrics, MatchHandCalculation) {
  const std::vector<double> errors = {0.1, 0.3, 0.2, 0.2};
  const ErrorSummary summary = summarize(errors);
  EXPECT_EQ(summary.count, 4u);
  EXPECT_EQ(summary.max, 0.3);
  EXPECT_NEAR(summary.mean, 0.2, 1e-16);
  EXPECT_NEAR(summary.std, std::sqrt(0.005), 1e-15);
  EXPECT_EQ(summarize({}).count, 0u);
}

TEST(Metrics, SplitErrorsByClassAndContact) {
  const FrameSet set{.frames = RowMatrix<float>::Zero(4, 2),
                     .slip_index = Vector<float>{{0.0f, 0.5f, 1.0f, 0.5f}},
                     .shape_class = {0, 2, 0, 2},
                     .contact_nodes = {1, 1, 3, 3}};
  const std::vector<double> errors = absolute_errors(Vector<float>{{0.25f, 0.5f, 0.5f, NAN}}, set);
  const ErrorReport report = report_errors(errors, set);
  EXPECT_EQ(report.all.count, 3u);
  EXPECT_EQ(report.without_answer, 1u);
  EXPECT_EQ(report.all.mean, 0.25);
  EXPECT_EQ(report.by_class.at(0).max, 0.5);
  EXPECT_EQ(report.by_class.at(0).mean, 0.375);
  EXPECT_EQ(report.by_class.at(2).count, 1u);
  EXPECT_EQ(report.by_contact_nodes.at(1).mean, 0.125);
  EXPECT_EQ(report.by_contact_nodes.at(3).count, 1u);
}

TEST(Metrics, QuantilesInterpolate) {
  const std::vector<double> values = {4, 1, 3, 2, 5};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.5), 3);
  EXPECT_EQ(quantile(values, 1), 5);
  EXPECT_NEAR(quantile(values, 0.05), 1.2, 1e-15);
  EXPECT_EQ(quantile({7}, 0.95), 7);
  EXPECT_THROW(quantile({}, 0.5), ValueError);
  EXPECT_THROW(quantile(values, 1.5), ValueError);
}

}  // namespace metrics_test
