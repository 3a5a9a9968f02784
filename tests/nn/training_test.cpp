// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "fem/numbers/value_error.h"
#include "nn/train_batch.h"
#include "nn/train_online.h"
#include "tests/nn/random_set.h"

namespace training_test {

using namespace tactel;
using namespace tactel::nn;

double largest_difference(const Weights<double>& a, const Weights<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) largest = std::max(largest, std::abs(a.values[i] - b.values[i]));
  return largest;
}

double mean_half_square(const Weights<double>& weights, const TrainingSet<double>& set) {
  double sum = 0;
  for (int row = 0; row < set.inputs.rows(); ++row) {
    const double error = set.target(row) - forward<double>(weights, set.inputs.row(row).transpose()).back()(0);
    sum += 0.5 * error * error;
  }
  return sum / static_cast<double>(set.inputs.rows());
}

// A network 2-1-1 and one pattern, shown twice: the rule written out, term by term.
TEST(TrainOnline, FollowsTheRuleWorkedByHand) {
  const auto f = [](double z) { return 0.5 * std::tanh(z / 2); };
  double w[5] = {0.3, -0.2, 0.1, 0.7, -0.4},
         step[5] = {};  // two inputs and bias of the hidden neuron; its weight and the bias of the output
  Weights<float> initial(Topology({2, 1, 1}));
  for (int i = 0; i < 5; ++i) w[i] = initial.values[i] = static_cast<float>(w[i]);
  OnlineState<double> state(initial);
  const TrainingSet<double> set{RowMatrix<double>{{0.6, -0.9}}, Vector<double>{{0.35}}};
  for (int t = 0; t < 2; ++t) {
    const double h = f(w[0] * 0.6 + w[1] * -0.9 + w[2]), o = f(w[3] * h + w[4]);
    const double d = (0.35 - o) * (0.25 - o * o), dh = (0.25 - h * h) * w[3] * d;
    const double gradient[5] = {dh * 0.6, dh * -0.9, dh, d * h, d};
    for (int i = 0; i < 5; ++i) w[i] += step[i] = 0.1 * gradient[i] + 0.9 * step[i];
    const CycleErrors errors = train_cycle(state, set, {}, 1);
    EXPECT_NEAR(errors.sse, (0.35 - o) * (0.35 - o), 1e-15);
    EXPECT_NEAR(errors.largest, 0.35 - o, 1e-15);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(state.weights.values[i], w[i], 1e-15) << "cycle " << t << " weight " << i;
  }
  EXPECT_EQ(state.cycle, 2u);
}

TEST(TrainOnline, StopsWhenEveryErrorIsSmall) {
  const TrainingSet<double> set = random_set(12, 4, 3);
  OnlineState<double> state(initial_weights(Topology({4, 8, 1}), 2));
  const CycleErrors errors = train_online(state, set, {}, 2, 20000);
  EXPECT_EQ(state.status, TrainStatus::learnt);
  EXPECT_LT(errors.largest, 0.01);
  EXPECT_LT(state.cycle, 10000u);
}

TEST(TrainOnline, StopsAtTheLimitAndGoesOnFromWhereItWas) {
  const TrainingSet<double> set = random_set(20, 4, 3);
  const OnlineOptions options{.cycle_limit = 30};
  OnlineState<double> whole(initial_weights(Topology({4, 3, 1}), 7)), parts = whole;
  train_online(whole, set, options, 7, 1000);
  for (int part = 0; part < 5; ++part) train_online(parts, set, options, 7, 11);
  EXPECT_EQ(whole.status, TrainStatus::cycle_limit);
  EXPECT_EQ(whole.cycle, 30u);
  EXPECT_EQ(parts.cycle, 30u);
  EXPECT_EQ(whole.weights.values, parts.weights.values);
}

TEST(TrainOnline, SaysWhenWeightsAreNotFinite) {
  OnlineState<double> state(initial_weights(Topology({4, 3, 1}), 7));
  state.weights.values[0] = NAN;
  train_online(state, random_set(5, 4, 3), {}, 7, 10);
  EXPECT_EQ(state.status, TrainStatus::not_finite);
  EXPECT_EQ(state.cycle, 1u);
}

TEST(TrainOnline, RefusesOptionsThatCannotWork) {
  EXPECT_THROW((OnlineOptions{.rate = 0}.validate()), ValueError);
  EXPECT_THROW((OnlineOptions{.momentum = 1}.validate()), ValueError);
  EXPECT_THROW((OnlineOptions{.stop_error = -1}.validate()), ValueError);
  EXPECT_THROW((OnlineOptions{.cycle_limit = -1}.validate()), ValueError);
}

// With one pattern a batch, the delta rule on batches is the rule above: same steps, up to the order of one
// multiplication.
TEST(TrainBatch, OfOnePatternIsTheOnlineRule) {
  const TrainingSet<double> set = random_set(20, 4, 3);
  const Weights<float> initial = initial_weights(Topology({4, 6, 3, 1}), 8);
  OnlineState<double> online(initial);
  BatchState<double> batch(initial);
  for (int cycle = 0; cycle < 5; ++cycle) {
    train_cycle(online, set, {}, 11);
    train_epoch(batch, set, {.rule = BatchRule::delta, .batch = 1, .rate = 0.1}, 11);
  }
  EXPECT_LT(largest_difference(online.weights, batch.weights), 1e-13);  // 100 updates, each a few ulp of 1
  EXPECT_EQ(batch.updates, 100u);
}

TEST(TrainBatch, DescentMatchesFiniteDifferences) {
  const TrainingSet<double> set = random_set(7, 4, 3);
  Weights<double> weights(initial_weights(Topology({4, 5, 3, 1}), 8));
  const std::vector<std::uint32_t> rows = presentation_order(PresentationOrder::sequential, 0, 0, 7);
  CycleErrors errors;
  const Weights<double> descent = mean_descent(weights, set, rows.data(), rows.size(), errors);
  EXPECT_NEAR(errors.sse, 2 * 7 * mean_half_square(weights, set), 1e-14);
  const double h = 1e-5;  // truncation ~ h^2, rounding ~ 1e-17 / h
  for (std::size_t i = 0; i < weights.values.size(); ++i) {
    Weights<double> above = weights, below = weights;
    above.values[i] += h;
    below.values[i] -= h;
    EXPECT_NEAR(descent.values[i], -(mean_half_square(above, set) - mean_half_square(below, set)) / (2 * h), 1e-10);
  }
}

// Adam's first step is rate g / (|g| + epsilon), whatever the moments' decay (its bias corrections cancel it).
TEST(TrainBatch, AdamsFirstStepIsKnown) {
  const Topology topology({2, 1, 1});
  BatchState<double> state{initial_weights(topology, 1)};
  const Weights<double> before = state.weights;
  Weights<double> descent(topology);
  descent.values = {0.3, -2e-5, 0, 4e-9, 1.0};
  const BatchOptions options{.rate = 0.01};
  apply_update(state, descent, options);
  for (std::size_t i = 0; i < descent.values.size(); ++i) {
    const double g = descent.values[i];
    EXPECT_NEAR(state.weights.values[i] - before.values[i], 0.01 * g / (std::abs(g) + 1e-8),
                1e-14);  // 1 - beta2: 13 digits
  }
}

// The same of the absolute loss; no error is within h of 0, where it has a corner.
TEST(TrainBatch, AbsoluteDescentMatchesFiniteDifferences) {
  const TrainingSet<double> set = random_set(7, 4, 3);
  Weights<double> weights(initial_weights(Topology({4, 5, 3, 1}), 8));
  const std::vector<std::uint32_t> rows = presentation_order(PresentationOrder::sequential, 0, 0, 7);
  CycleErrors errors;
  const Weights<double> descent =
      mean_descent(weights, set, rows.data(), rows.size(), errors, {.loss = Loss::absolute});
  EXPECT_NEAR(errors.sse, 2 * 7 * mean_half_square(weights, set), 1e-14);  // the errors stay errors
  const auto mean_magnitude = [&](const Weights<double>& its) {
    double sum = 0;
    for (int row = 0; row < 7; ++row)
      sum += std::abs(set.target(row) - forward<double>(its, set.inputs.row(row).transpose()).back()(0));
    return sum / 7;
  };
  const double h = 1e-5;
  for (std::size_t i = 0; i < weights.values.size(); ++i) {
    Weights<double> above = weights, below = weights;
    above.values[i] += h;
    below.values[i] -= h;
    EXPECT_NEAR(descent.values[i], -(mean_magnitude(above) - mean_magnitude(below)) / (2 * h), 1e-10);
  }
}

// 1000 rows in batches of 100, 20 % of warm-up: the middles of the batches lie at 5 %, 15 %, 25 %, ... of the training.
// Behind the warm-up the angle of the cosine is 180 degrees * (done - .2) / .8.
TEST(TrainBatch, RateWarmsUpAndFallsAsACosine) {
  const BatchOptions options{.rate = 0.002, .cosine = true, .warm_up = 0.2, .planned_rows = 1000};
  EXPECT_DOUBLE_EQ(options.rate_of(0, 100), 0.0005);
  EXPECT_DOUBLE_EQ(options.rate_of(100, 100), 0.0015);
  EXPECT_NEAR(options.rate_of(150, 100), 0.002, 1e-17);                   // 0 degrees
  EXPECT_NEAR(options.rate_of(550, 100), 0.001, 1e-17);                   // 90 degrees
  EXPECT_NEAR(options.rate_of(750, 100), 0.00029289321881345254, 1e-17);  // 135 degrees: (1 - sqrt(1/2)) / 1000
  EXPECT_NEAR(options.rate_of(900, 100), 0.00001921471959676957, 1e-16);  // 168.75 degrees
  EXPECT_EQ(options.rate_of(5000, 100), 0);                               // a last block may have rows beyond the plan
  EXPECT_EQ((BatchOptions{.rate = 0.3}.rate_of(900, 100)), 0.3);
  EXPECT_DOUBLE_EQ((BatchOptions{.rate = 2, .cosine = true, .warm_up = 0, .planned_rows = 4}.rate_of(1, 2)), 1);
}

// 10 rows in batches of 4: 4, 4 and 2, of an epoch of two. Plain descent without momentum gives the rate of each.
TEST(TrainBatch, EveryBatchHasItsOwnRate) {
  const Topology topology({2, 1, 1});
  BatchState<double> state{initial_weights(topology, 1)};
  Weights<double> descent(topology);
  descent.values = {1, 1, 1, 1, 1};
  const BatchOptions options{.rule = BatchRule::delta,
                             .batch = 4,
                             .rate = 1,
                             .cosine = true,
                             .warm_up = 0.5,
                             .planned_rows = 20,
                             .momentum = 0};
  // middles 2, 6, 9, 12, 16, 19 of 20: rising by a tenth a row until 10, then cosines of 36, 108 and 162 degrees
  const double rates[] = {0.2, 0.6, 0.9, 0.9045084971874737, 0.3454915028125263, 0.024471741852423234};
  const std::size_t counts[] = {4, 4, 2, 4, 4, 2};
  for (int i = 0; i < 6; ++i) {
    const double before = state.weights.values[3];
    apply_update(state, descent, options, counts[i]);
    EXPECT_NEAR(state.weights.values[3] - before, rates[i], 1e-15) << i;
  }
  EXPECT_EQ(state.rows, 20u);
}

// A network 1-1-1, two updates that add 0.5 and then 0.25 to every weight. With a decay d = 0.6 the mean after the
// first is that update's weights; after the second (d w1 + w2) / (1 + d) = w1 + 0.25 / 1.6.
TEST(TrainBatch, MeanOfWeightsWorkedByHand) {
  const Topology topology({1, 1, 1});
  BatchState<double> state{initial_weights(topology, 1)};
  const Weights<double> start = state.weights;
  EXPECT_EQ(state.result().values, start.values);
  const BatchOptions options{.rule = BatchRule::delta, .rate = 0.5, .momentum = 0, .average = 0.6};
  Weights<double> descent(topology);
  descent.values = {1, 1, 1, 1};
  apply_update(state, descent, options);
  EXPECT_EQ(state.result().values, state.weights.values);
  descent.values = {0.5, 0.5, 0.5, 0.5};
  apply_update(state, descent, options);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(state.weights.values[i], start.values[i] + 0.75, 1e-15);
    EXPECT_NEAR(state.result().values[i], start.values[i] + 0.5 + 0.15625, 1e-15);
  }
}

TEST(TrainBatch, RefusesSharesThatAreNone) {
  for (const double share : {-0.1, 1.0, std::nan("")}) {
    EXPECT_THROW((BatchOptions{.warm_up = share}.validate()), ValueError) << share;
    EXPECT_THROW((BatchOptions{.average = share}.validate()), ValueError) << share;
  }
}

TEST(TrainBatch, LearnsWithBothRules) {
  const TrainingSet<double> set = random_set(50, 4, 3);
  for (const BatchOptions& options : {BatchOptions{.rule = BatchRule::adam, .batch = 8, .rate = 0.01},
                                      BatchOptions{.rule = BatchRule::delta, .batch = 8, .rate = 0.5}}) {
    BatchState<double> state(initial_weights(Topology({4, 8, 1}), 2));
    const double first = train_epoch(state, set, options, 2).sse;
    double last = 0;
    for (int epoch = 0; epoch < 300; ++epoch) last = train_epoch(state, set, options, 2).sse;
    EXPECT_LT(last, 0.05 * first) << name(options.rule);
  }
  EXPECT_THROW((BatchOptions{.batch = 0}.validate()), ValueError);
  EXPECT_THROW((BatchOptions{.beta2 = 1}.validate()), ValueError);
}

}  // namespace training_test
