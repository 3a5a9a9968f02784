// SPDX-License-Identifier: Apache-2.0

// The mini-batch kernels against their Eigen twin, against finite differences, and against what every training must
// obey.
#include "host/networks/train_batch.h"

#include <gtest/gtest.h>

#include "fem/numbers/value_error.h"
#include "nn/quantile_heads.h"
#include "tests/host/networks/network_cases.h"

namespace train_batch_test {

using namespace tactel;
using namespace tactel::host;
using nn::BatchOptions;
using nn::BatchRule;
using tactel::tests::bumps;
using tactel::tests::executor;
using tactel::tests::largest_difference;

template <class Real>
struct BatchCase {
  nn::Topology topology;
  nn::FrameSet set;
  BatchOptions options;
  nn::InputScaling scaling = nn::fit_scaling(nn::ScalingKind::set, set);
  std::vector<SetVariant> variants{{0, 0}, {0.1, 5}};
  LearningInputs<Real> inputs{executor().device(), set, scaling, variants};

  TrainBatch<Real> device(const std::vector<OnlineMember>& members, Executor& on = executor()) const {
    return {on, topology, inputs, members, options};
  }
  template <class Scalar>
  nn::BatchState<Scalar> reference(const OnlineMember& member, int epochs, nn::CycleErrors* last = nullptr) const {
    const SetVariant& variant = variants[member.variant];
    const auto shown = nn::training_set<Scalar>(nn::with_noise(set, variant.noise, variant.seed), scaling);
    nn::BatchState<Scalar> state(nn::initial_weights(topology, member.seed));
    for (int epoch = 0; epoch < epochs; ++epoch) {
      const nn::CycleErrors errors = nn::train_epoch(state, shown, options, member.seed);
      if (last) *last = errors;
    }
    return state;
  }
};

template <class Real>
BatchCase<Real> make_case(const char* topology, int rows, const BatchOptions& options) {
  const nn::Topology network = nn::Topology::parse(topology);
  return {network, bumps(rows, network.inputs(), 3), options};
}

struct Shape {
  const char* topology;
  int rows, batch;
};
void PrintTo(const Shape& shape, std::ostream* out) {
  *out << shape.topology << ", " << shape.rows << " rows, batch " << shape.batch;
}

class TrainBatchTest : public ::testing::TestWithParam<Shape> {};

// Sums of some hundred terms in another order: 1e-16 each update in fp64; Adam divides by the root of the second
// moment, which magnifies where gradients are small: from there some 1e-12 over ten epochs. No rectifier's sum comes so
// near to 0.
TEST_P(TrainBatchTest, Fp64MatchesReference) {
  const Shape shape = GetParam();
  for (const BatchRule rule : {BatchRule::delta, BatchRule::adam}) {
    const auto c = make_case<double>(
        shape.topology, shape.rows, {.rule = rule, .batch = shape.batch, .rate = rule == BatchRule::adam ? 0.01 : 0.3});
    TrainBatch<double> device = c.device({{7, 0}, {8, 1}});
    std::vector<nn::CycleErrors> errors;
    for (int epoch = 0; epoch < 10; ++epoch) errors = *device.train_epoch();
    for (const OnlineMember member : {OnlineMember{7, 0}, OnlineMember{8, 1}}) {
      nn::CycleErrors expected;
      const nn::BatchState<double> reference = c.reference<double>(member, 10, &expected);
      const nn::BatchState<double> state = device.state(member.variant);
      EXPECT_LT(largest_difference(state.weights.values, reference.weights.values), 1e-10) << nn::name(rule);
      EXPECT_LT(largest_difference(state.first.values, reference.first.values), 1e-10) << nn::name(rule);
      EXPECT_NEAR(errors[member.variant].sse, expected.sse, 1e-10 * expected.sse);
      EXPECT_NEAR(errors[member.variant].largest, expected.largest, 1e-10);
      EXPECT_EQ(state.updates, reference.updates);
      EXPECT_EQ(state.epoch, 10u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, TrainBatchTest,
                         ::testing::Values(Shape{"16-16-8-1", 100, 1}, Shape{"16-16-8-1", 100, 7},
                                           Shape{"16-16-8-1", 100, 32}, Shape{"16-16-8-1", 100, 64},
                                           Shape{"16-16-8-1", 1000, 128}, Shape{"16-16-8-1", 1000, 129},
                                           Shape{"16-16-8-1", 1000, 600}, Shape{"16-16-8-1", 300, 1000},
                                           Shape{"2-1-1", 50, 16}, Shape{"16-16-8-3", 100, 32},
                                           Shape{"16-16-8-3", 300, 200}, Shape{"16-16-8-3_leaky-relu", 100, 32}));
INSTANTIATE_TEST_SUITE_P(Nightly, TrainBatchTest,
                         ::testing::Values(Shape{"30-31-33-1", 70, 33}, Shape{"18-33-1", 70, 33},
                                           Shape{"18-33-3", 70, 33}, Shape{"18-33-1_leaky-relu", 300, 200}));

// The same with the absolute loss, a rate of every batch's own and the mean of the weights. No error comes so near to 0
// that its sign is in doubt.
TEST_P(TrainBatchTest, Fp64OfCosineMatchesReference) {
  const Shape shape = GetParam();
  const BatchOptions options{.batch = shape.batch,
                             .rate = 0.01,
                             .cosine = true,
                             .warm_up = 0.1,
                             .planned_rows = static_cast<std::uint64_t>(10 * shape.rows),
                             .loss = nn::Loss::absolute,
                             .average = 0.9};
  const auto c = make_case<double>(shape.topology, shape.rows, options);
  TrainBatch<double> device = c.device({{7, 0}, {8, 1}});
  for (int epoch = 0; epoch < 10; ++epoch) device.train_epoch();
  for (const OnlineMember member : {OnlineMember{7, 0}, OnlineMember{8, 1}}) {
    const nn::BatchState<double> reference = c.reference<double>(member, 10), state = device.state(member.variant);
    EXPECT_LT(largest_difference(state.weights.values, reference.weights.values), 1e-10);
    ASSERT_EQ(state.mean.values.size(), reference.mean.values.size());
    EXPECT_LT(largest_difference(state.result().values, reference.mean.values), 1e-10);
    EXPECT_GT(largest_difference(state.result().values, reference.weights.values), 1e-6);
    EXPECT_EQ(state.rows, reference.rows);
  }
}

// fp32 beside the Eigen reference in fp32: the kernel may stray from fp64 as far as that does, within a factor of 4.
// The delta rule; Adam's first steps depend on the sign of gradients that rounding decides.
TEST(TrainBatchFp32, MatchesReferenceToItsPrecision) {
  const auto c = make_case<float>("6", 200, {.rule = BatchRule::delta, .batch = 64, .rate = 0.3});
  TrainBatch<float> device = c.device({{7, 0}});
  for (int epoch = 0; epoch < 50; ++epoch) device.train_epoch();
  const nn::Weights<double> truth = c.reference<double>({7, 0}, 50).weights;
  const nn::Weights<double> eigen(c.reference<float>({7, 0}, 50).weights), kernel(device.state(0).weights);
  const double yardstick = largest_difference(eigen.values, truth.values);
  EXPECT_LT(largest_difference(kernel.values, truth.values), 4 * yardstick);
  EXPECT_LT(yardstick, 1e-4);
}

/// One step of the delta rule from rest is minus the gradient of the mean of loss(outputs, target): by central
/// differences of recall itself, a distance h apart.
template <class Loss>
void expect_step_along_gradient(const char* topology, const BatchOptions& options, double h, double tolerance,
                                const Loss& loss) {
  const auto c = make_case<double>(topology, options.batch, options);
  TrainBatch<double> device = c.device({{7, 0}});
  device.train_epoch();
  const nn::BatchState<double> state = device.state(0);
  const auto shown = nn::training_set<double>(c.set, c.scaling);
  const auto mean_loss = [&](const nn::Weights<double>& weights) {
    double sum = 0;
    for (int row = 0; row < options.batch; ++row)
      sum += loss(nn::forward<double>(weights, shown.inputs.row(row).transpose()).back(), shown.target(row));
    return sum / options.batch;
  };
  const nn::Weights<double> initial(nn::initial_weights(c.topology, 7));
  for (std::size_t i = 0; i < initial.values.size(); i += 3) {
    nn::Weights<double> above = initial, below = initial;
    above.values[i] += h;
    below.values[i] -= h;
    EXPECT_NEAR(state.first.values[i], -(mean_loss(above) - mean_loss(below)) / (2 * h), tolerance) << i;
  }
}

// Of 1/2 error^2. Truncation ~ h^2, rounding ~ 1e-17 / h.
TEST(TrainBatchGradient, MatchesFiniteDifferences) {
  expect_step_along_gradient("16-16-8-1", {.rule = BatchRule::delta, .batch = 150, .rate = 1.0}, 1e-5, 1e-10,
                             [](const auto& outputs, double target) { return std::pow(target - outputs(0), 2) / 2; });
}

// Of the pinball loss, for the heads of a bound. Rounding ~ 1e-16 / h; no S lies within h of a quantile.
TEST(TrainBatchGradient, OfQuantilesMatchesFiniteDifferences) {
  expect_step_along_gradient(
      "16-16-8-3", {.rule = BatchRule::delta, .batch = 150, .rate = 1.0, .level = 0.9}, 1e-6, 1e-9,
      [](const auto& outputs, double target) { return nn::quantile_loss(outputs, target + 0.5, 0.9); });
}

// Bits: free of the number of threads, of what else is trained, and of a break between epochs. Both kinds of batches.
TEST(TrainBatchBits, DependOnTheNetworkAlone) {
  for (const int batch : {50, 200}) {
    const BatchOptions options{.batch = batch, .rate = 0.01, .cosine = true, .planned_rows = 4 * 437, .average = 0.9};
    const auto c = make_case<float>("16-16-8-1", 437, options);
    Executor single(executor().device(), {.threads = 1});
    TrainBatch<float> together = c.device({{1, 0}, {2, 1}, {3, 0}}), alone = c.device({{2, 1}}, single);
    for (int epoch = 0; epoch < 4; ++epoch) together.train_epoch();
    const std::vector<float> initial = alone.state(0).weights.values;
    alone.train_epoch();
    EXPECT_NE(alone.state(0).weights.values, initial);
    TrainBatch<float> resumed = c.device({{2, 1}}, single);
    resumed.set_state(0, alone.state(0));
    for (int epoch = 1; epoch < 4; ++epoch) resumed.train_epoch();
    EXPECT_EQ(resumed.state(0).weights.values, together.state(1).weights.values) << batch;
    EXPECT_EQ(resumed.state(0).second.values, together.state(1).second.values) << batch;
    EXPECT_EQ(resumed.state(0).mean.values, together.state(1).mean.values) << batch;
    EXPECT_EQ(resumed.state(0).updates, together.state(1).updates) << batch;
  }
}

TEST(TrainBatchCancel, LeavesTheNetworksAsTheyWere) {
  for (const int batch : {50, 200}) {
    const auto c = make_case<float>("16-16-8-1", 437, {.batch = batch, .average = 0.9});
    TrainBatch<float> device = c.device({{1, 0}});
    device.train_epoch();
    const nn::BatchState<float> before = device.state(0);
    EXPECT_FALSE(device.train_epoch([](std::size_t, std::size_t) { return false; }));
    EXPECT_EQ(device.state(0).weights.values, before.weights.values);
    EXPECT_EQ(device.state(0).mean.values, before.mean.values);
    EXPECT_EQ(device.state(0).epoch, 1u);
    EXPECT_EQ(device.state(0).rows, 437u);
    std::size_t last = 0;
    const auto note = [&last](std::size_t done, std::size_t total) {
      EXPECT_LE(last, done);
      last = done;
      return total == 437;
    };
    EXPECT_TRUE(device.train_epoch(note));
    EXPECT_EQ(last, 437u);
  }
}

TEST(TrainBatchRefuses, WhatDoesNotFit) {
  const auto c = make_case<float>("16-16-8-1", 20, {});
  EXPECT_THROW(TrainBatch<float>(executor(), nn::Topology::paper(1), c.inputs, std::vector<OnlineMember>{{1, 0}}),
               ValueError);
  EXPECT_THROW(TrainBatch<float>(executor(), c.topology, c.inputs, std::vector<OnlineMember>{{1, 0}}, {.batch = 0}),
               ValueError);
}

}  // namespace train_batch_test
