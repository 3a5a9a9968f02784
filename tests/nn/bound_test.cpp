// SPDX-License-Identifier: Apache-2.0

// Quantile heads and their conformal calibration: by hand, by central differences, and where coverage is known exactly.
#include "nn/bound.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numeric>
#include <random>

#include "nn/forward.h"
#include "nn/train_batch.h"
#include "tests/fem/expect_error.h"
#include "tests/nn/random_set.h"

namespace bound_test {

using namespace tactel;
using namespace tactel::nn;

/// Corrections of 0, as many as the classes have now.
void clear_corrections(Bound& bound) {
  bound.upper_correction.assign(bound.classes(), 0);
  bound.interval_correction = bound.upper_correction;
}

/// A bound of two inputs, one tactel, with one class for everything.
Bound plain_bound() {
  Bound bound = uncalibrated_bound(RowMatrix<float>{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}, 1);
  bound.touching = {1e9f};
  bound.slip_index = {1e9f};
  bound.width = {1e9f};
  clear_corrections(bound);
  return bound;
}

// o = (-0.2, -0.4, -0.3): median 0.3, widths 0.1 and 0.2.
TEST(QuantileHeads, AreTheFormulas) {
  const Vector<double> o{{-0.2, -0.4, -0.3}};
  const Quantiles<double> q = quantiles(o);
  EXPECT_NEAR(q.median, 0.3, 1e-15);
  EXPECT_NEAR(q.upper, 0.4, 1e-15);
  EXPECT_NEAR(q.lower, 0.1, 1e-15);
  // Target 0.35: 0.5 * 0.05 + 0.1 * 0.05 (below the upper quantile, level 0.9) + 0.1 * 0.25 (above the lower).
  EXPECT_NEAR(quantile_loss(o, 0.35, 0.9), 0.025 + 0.005 + 0.025, 1e-15);
  // -dL/dq: 0.5, 0.9 - 1, 0.1; all three move with the median, the widths have one each, the lower with a minus.
  const Vector<double> e = quantile_errors(o, 0.35, 0.9);
  EXPECT_NEAR(e(0), 0.5 - 0.1 + 0.1, 1e-15);
  EXPECT_NEAR(e(1), -0.1, 1e-15);
  EXPECT_NEAR(e(2), -0.1, 1e-15);
}

// Whatever the weights: lower < median < upper.
TEST(QuantileHeads, CannotCross) {
  const TrainingSet<double> set = random_set(200, 4, 5);
  for (const double size : {1.0, 30.0}) {
    Weights<double> weights(initial_weights(Topology({4, 5, 3}), 3));
    for (double& w : weights.values) w *= size;
    for (int row = 0; row < 200; ++row) {
      const Quantiles<double> q = quantiles(forward<double>(weights, set.inputs.row(row).transpose()).back());
      EXPECT_LE(q.lower, q.median);
      EXPECT_LE(q.median, q.upper);
    }
  }
}

TEST(QuantileHeads, DescentMatchesFiniteDifferences) {
  const TrainingSet<double> set = random_set(7, 4, 3);
  const Weights<double> weights(initial_weights(Topology({4, 5, 3, 3}), 8));
  const double level = 0.9;
  const auto mean_loss = [&](const Weights<double>& w) {
    double sum = 0;
    for (int row = 0; row < 7; ++row)
      sum += quantile_loss(forward<double>(w, set.inputs.row(row).transpose()).back(), set.target(row) + 0.5, level);
    return sum / 7;
  };
  const std::vector<std::uint32_t> rows = presentation_order(PresentationOrder::sequential, 0, 0, 7);
  CycleErrors errors;
  const Weights<double> descent = mean_descent(weights, set, rows.data(), rows.size(), errors, {.level = level});
  const double h = 1e-6;  // truncation ~ h^2, rounding ~ 1e-16 / h; no target lies within h of a quantile
  for (std::size_t i = 0; i < weights.values.size(); ++i) {
    Weights<double> above = weights, below = weights;
    above.values[i] += h;
    below.values[i] -= h;
    EXPECT_NEAR(descent.values[i], -(mean_loss(above) - mean_loss(below)) / (2 * h), 1e-9) << i;
  }
}

// A target that the inputs do not tell, uniform in 0..1: the quantiles become its own, 0.05, 0.5 and 0.95. The pinball
// loss of n rows is flat to about 1 / sqrt(n) beside its minimum: 2000 rows, 0.03.
TEST(QuantileHeads, LearnTheQuantiles) {
  TrainingSet<double> set{RowMatrix<double>::Zero(2000, 2), Vector<double>(2000)};
  for (int row = 0; row < 2000; ++row) set.target(row) = (row + 0.5) / 2000 - 0.5;
  BatchState<double> state(initial_weights(Topology({2, 2, 3}), 4));
  for (int epoch = 0; epoch < 150; ++epoch) train_epoch(state, set, {.batch = 100, .rate = 0.01, .level = 0.95}, 1);
  const Quantiles<double> q = quantiles(forward<double>(state.weights, Vector<double>::Zero(2)).back());
  EXPECT_NEAR(q.lower, 0.05, 0.03);
  EXPECT_NEAR(q.median, 0.5, 0.03);
  EXPECT_NEAR(q.upper, 0.95, 0.03);
}

// ceil((n + 1) level): of 19 scores at 95 % the 19th, of 39 the 38th, of 20 at 90 % the 19th (18.9).
TEST(Conformal, TakesTheRank) {
  const auto scores = [](int n) {
    std::vector<double> all(static_cast<std::size_t>(n));
    std::iota(all.rbegin(), all.rend(), 1);  // n ... 1
    return all;
  };
  EXPECT_EQ(conformal_quantile(scores(19), 0.95), 19);
  EXPECT_EQ(conformal_quantile(scores(39), 0.95), 38);
  EXPECT_EQ(conformal_quantile(scores(20), 0.9), 19);
  EXPECT_EQ(conformal_quantile(scores(9), 0.9), 9);
  EXPECT_EQ(fewest_scores(0.95), 19u);
  EXPECT_EQ(fewest_scores(0.9), 9u);
  EXPECT_EQ(fewest_scores(0.999), 999u);
}

TEST(Conformal, SaysWhenThereAreTooFewRows) {
  expect_value_error([] { conformal_quantile(std::vector<double>(18, 0.0), 0.95); }, "rows", "18", "at least 19");
}

// Quantiles 0.2, 0.4, 0.5 of every row and S = 0.01 k, k = 31 ... 69: S - 0.5 has the 38th smallest of 39 at S = 0.68,
// 0.18; max(S - 0.5, 0.2 - S) the same. S of a row then is below 0.68, and within 0.2 - 0.18 and 0.68.
TEST(Conformal, CorrectsAHandWorkedSet) {
  Bound bound = plain_bound();
  const float frame[2] = {1, 0};
  std::vector<CalibrationRow> rows;
  for (int k = 31; k < 70; ++k) rows.push_back({{0.4f, 0.5f, 0.2f}, 0.01f * static_cast<float>(k), frame});
  const Calibration report = calibrate(bound, rows, 0.95);
  EXPECT_EQ(report.rows, 39u);
  EXPECT_EQ(report.own_classes, 0u);  // of all classes' rows, for every class has fewer than 200
  EXPECT_FALSE(report.known);
  EXPECT_EQ(bound.unlike_above, std::numeric_limits<float>::max());
  for (const float c : bound.upper_correction) EXPECT_NEAR(c, 0.18, 1e-6);
  for (const float c : bound.interval_correction) EXPECT_NEAR(c, 0.18, 1e-6);
  const BoundAnswer answer = bounded(bound, {0.4f, 0.5f, 0.2f}, frame);
  EXPECT_NEAR(answer.upper, 0.68, 1e-6);
  EXPECT_NEAR(answer.interval[0], 0.02, 1e-6);
  EXPECT_NEAR(answer.interval[1], 0.68, 1e-6);
  EXPECT_FALSE(answer.unlike);
}

// A correction below zero does not push the bound beyond S, and nothing is above 1.
TEST(Conformal, KeepsTheBoundOnItsSide) {
  Bound bound = plain_bound();
  const float frame[2] = {1, 0};
  bound.upper_correction.assign(bound.classes(), -0.3f);
  bound.interval_correction.assign(bound.classes(), -0.3f);
  BoundAnswer answer = bounded(bound, {0.4f, 0.5f, 0.2f}, frame);
  EXPECT_EQ(answer.upper, 0.4f);
  EXPECT_EQ(answer.interval[0], 0.4f);
  EXPECT_EQ(answer.interval[1], 0.4f);
  bound.upper_correction.assign(bound.classes(), 0.7f);
  answer = bounded(bound, {0.4f, 0.5f, 0.2f}, frame);
  EXPECT_EQ(answer.upper, 1.0f);
}

// The classes of (touching 3, S 0.5, width 0.15) with edges {1.5, 2.5}, {0.4}, {0.1, 0.2}: 2, 1, 1 of 3 x 2 x 3; then
// of
// (.., distance 7) with edges {5}: 1 of 2.
TEST(Conformal, FindsTheClass) {
  Bound bound = plain_bound();
  bound.touching = {1.5f, 2.5f};
  bound.slip_index = {0.4f};
  bound.width = {0.1f, 0.2f};
  EXPECT_EQ(bound.classes(), 18u);
  EXPECT_EQ(bound.class_of(3, {0.5f, 0.6f, 0.45f}, 7), 2u * 6 + 1 * 3 + 1);
  EXPECT_EQ(bound.class_of(1, {0.4f, 0.41f, 0.4f}, 7), 0u);  // on an edge is below it
  bound.distance = {5};
  EXPECT_EQ(bound.classes(), 36u);
  EXPECT_EQ(bound.class_of(3, {0.5f, 0.6f, 0.45f}, 7), 2u * (2u * 6 + 1 * 3 + 1) + 1);
  EXPECT_EQ(bound.class_of(1, {0.4f, 0.41f, 0.4f}, 5), 0u);
  const float frame[6] = {-0.04f, -1, 0.06f, 9, 9, 9};  // 5 % of the largest normal stress is 0.05
  EXPECT_EQ(touching_tactels(frame, 3), 2);
}

// S uniform in 0..1 above a quantile of 0: the share of new rows below the correction is the correction itself. With n
// rows it is the k-th smallest of n uniform numbers, k = ceil((n + 1) level), whose mean is k / (n + 1), at least the
// level: coverage is exact for every n (Beta(k, n + 1 - k), standard deviation below 0.07 here; 4000 trials, four
// standard errors).
TEST(Conformal, CoversExactlyInSmallSamples) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform;
  const float frame[2] = {1, 0};
  for (const int n : {19, 39, 42, 60}) {
    double sum = 0;
    for (int trial = 0; trial < 4000; ++trial) {
      Bound bound = plain_bound();
      std::vector<CalibrationRow> rows;
      rows.reserve(static_cast<std::size_t>(n));
      for (int k = 0; k < n; ++k) rows.push_back({{0, 0, 0}, uniform(random), frame});
      calibrate(bound, rows, 0.9);
      sum += double(bounded(bound, {0, 0, 0}, frame).upper);
    }
    const double expected = std::ceil((n + 1) * 0.9 - 1e-9) / (n + 1);
    EXPECT_GE(expected, 0.9);
    EXPECT_NEAR(sum / 4000, expected, 4 * 0.07 / std::sqrt(4000.0)) << n;
  }
}

// Frames (x, 0), x = 1 ... 2000, whose squared distances are x^2 / (variance of 1 on top of a noise): ascending with x.
// The edges stand at the ceil(2001 share)-th frames: 1201, 1721, 1881, 1961.
TEST(Conformal, RenewsTheClassesOfToday) {
  Bound bound = plain_bound();
  RowMatrix<float> frames = RowMatrix<float>::Zero(2000, 2);
  std::vector<CalibrationRow> rows;
  for (int k = 0; k < 2000; ++k) {
    frames(k, 0) = static_cast<float>(k + 1);
    rows.push_back({{0.5f, 0.6f, 0.4f}, 0.5f, frames.row(k).data()});
  }
  renew_classes(bound, rows);
  EXPECT_EQ(bound.touching, Bound().touching);
  EXPECT_EQ(bound.slip_index, Bound().slip_index);
  EXPECT_EQ(bound.width, Bound().width);
  ASSERT_EQ(bound.distance.size(), 4u);
  const int places[] = {1201, 1721, 1881, 1961};
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_EQ(bound.distance[k], squared_distance(bound, frames.row(places[k] - 1).data())) << k;
  EXPECT_EQ(bound.upper_correction, std::vector<float>(bound.classes(), 0.0f));
  bound.unlike_above = 1;
  bound.validate(2);
  renew_classes(bound, std::span(rows).first(998));  // too few to tell which frames are far
  EXPECT_TRUE(bound.distance.empty());
}

// The network says 0.5 and is right to 0.01 near the learning set and to 0.2 far from it: each has its own correction.
TEST(Conformal, WidensFarFrames) {
  Bound bound = plain_bound();
  bound.distance = {20};
  clear_corrections(bound);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const float near[2] = {1, 0}, far[2] = {10, 0};
  std::vector<CalibrationRow> rows;
  rows.reserve(4000);
  for (int k = 0; k < 4000; ++k)
    rows.push_back({{0.5f, 0.5f, 0.5f}, 0.5f + (k % 2 != 0 ? 0.2f : 0.01f) * uniform(random), k % 2 != 0 ? far : near});
  EXPECT_EQ(calibrate(bound, rows, 0.95).own_classes, 2u);
  // A uniform S is below 0.5 + 0.9 of its half width in 95 % of the rows; of 2000 rows the share has a standard
  // deviation of 0.5 %, and the correction one of 1 % of the half width.
  EXPECT_NEAR(bounded(bound, {0.5f, 0.5f, 0.5f}, near).upper, 0.5 + 0.01 * 0.9, 0.01 * 0.04);
  EXPECT_NEAR(bounded(bound, {0.5f, 0.5f, 0.5f}, far).upper, 0.5 + 0.2 * 0.9, 0.2 * 0.04);
}

// The network says 0.5 +- nothing; S is normal about 0.5 with deviation 0.05 in one class (S of the network above an
// edge) and 0.1 in the other. One correction a class must be 1.645 of each; one for both is not. Coverage of 20 000 new
// rows: 95 % within 0.6 % (4 standard deviations of a binomial with 20 000 rows and of the calibration's 20 000 rows).
TEST(Conformal, CoversEachClass) {
  Bound bound = plain_bound();
  bound.slip_index = {0.5f};
  clear_corrections(bound);
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  const float frame[2] = {1, 0};
  const auto draw = [&](int k) {
    const bool wide = k % 2 != 0;
    const float s = wide ? 0.51f : 0.49f;
    return CalibrationRow{{s, s, s}, 0.5f + (wide ? 0.1f : 0.05f) * normal(random), frame};
  };
  std::vector<CalibrationRow> rows;
  rows.reserve(40000);
  for (int k = 0; k < 40000; ++k) rows.push_back(draw(k));
  const Calibration report = calibrate(bound, rows, 0.95);
  EXPECT_EQ(report.own_classes, 2u);
  EXPECT_TRUE(report.known);
  int covered[2] = {0, 0}, within[2] = {0, 0};
  for (int k = 0; k < 40000; ++k) {
    const CalibrationRow row = draw(k);
    const BoundAnswer answer = bounded(bound, row.quantiles, row.scaled);
    covered[k % 2] += row.slip_index <= answer.upper;
    within[k % 2] += row.slip_index >= answer.interval[0] && row.slip_index <= answer.interval[1];
  }
  for (const int k : {0, 1}) {
    EXPECT_NEAR(covered[k] / 20000.0, 0.95, 0.006) << k;
    EXPECT_NEAR(within[k] / 20000.0, 0.95, 0.006) << k;
  }
}

// Frames of two independent inputs with deviations 2 and 0.5: the squared distance is (x/2)^2 + (y/0.5)^2, to the 0.1 %
// that is added; beyond 13.8 lies one in 1000 (chi-squared, two degrees), so the limit is 13.8 within 10 % (20 000
// rows: 20 beyond).
TEST(Conformal, KnowsItsFrames) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  RowMatrix<float> frames(20000, 2);
  for (int row = 0; row < 20000; ++row) frames.row(row) << 2 * normal(random), 0.5f * normal(random);
  Bound bound = uncalibrated_bound(frames, 1);
  const float at[2] = {3, 1};
  EXPECT_NEAR(squared_distance(bound, at), 9.0 / 4 + 1 / 0.25, 0.2);  // means and variances of 20 000 draws: 1 %
  std::vector<CalibrationRow> rows;
  rows.reserve(20000);
  for (int row = 0; row < 20000; ++row) rows.push_back({{0.5f, 0.6f, 0.4f}, 0.5f, frames.row(row).data()});
  EXPECT_TRUE(calibrate(bound, rows, 0.95).known);
  EXPECT_NEAR(bound.unlike_above, 13.8, 1.9);
  const float far[2] = {0, 3};
  EXPECT_TRUE(bounded(bound, {0.5f, 0.6f, 0.4f}, far).unlike);
  EXPECT_FALSE(bounded(bound, {0.5f, 0.6f, 0.4f}, at).unlike);
}

}  // namespace bound_test
