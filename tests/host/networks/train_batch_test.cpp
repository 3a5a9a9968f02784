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
using tactel::tests::gpu;
using tactel::tests::largest_difference;

template <class Real>
struct BatchCase {
  nn::Topology topology;
  nn::FrameSet set;
  BatchOptions options;
  nn::InputScaling scaling = nn::fit_scaling(nn::ScalingKind::set, set);
  std::vector<SetVariant> variants{{0, 0}, {0.1, 5}};
  Executor* on = &executor();
  LearningInputs<Real> inputs{on->device(), set, scaling, variants};

  TrainBatch<Real> device(const std::vector<OnlineMember>& members) const { return device(members, *on); }
  TrainBatch<Real> device(const std::vector<OnlineMember>& members, Executor& other) const {
    return {other, topology, inputs, members, options};
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
BatchCase<Real> make_case(const char* topology, int rows, const BatchOptions& options, Executor& on = executor()) {
  const nn::Topology network = nn::Topology::parse(topology);
  return {.topology = network, .set = bumps(rows, network.inputs(), 3), .options = options, .on = &on};
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

class TrainGroupBatch : public ::testing::TestWithParam<const char*> {};

// fp64: sums in another order, one epoch of 70 rows by 70 to 1 updates; a batch of all rows learns three. Of Adam the
// moments after the first two updates of a weight may cancel: its rate is small.
TEST_P(TrainGroupBatch, MatchesReference) {
  const std::vector<OnlineMember> some{{7, 0}, {8, 1}, {9, 1}};
  for (const BatchRule rule : {BatchRule::delta, BatchRule::adam})
    for (const int batch : {1, 7, 64, 300}) {
      const BatchOptions options{.rule = rule, .batch = batch, .rate = rule == BatchRule::adam ? 0.001 : 0.3};
      const auto c = make_case<double>(GetParam(), batch == 300 ? 300 : 70, options, gpu());
      ASSERT_GT(group_items(gpu().device(), c.topology), 1u);
      TrainBatch<double> device = c.device(some);
      const int epochs = batch == 300 ? 3 : 1;
      std::vector<nn::CycleErrors> errors;
      for (int epoch = 0; epoch < epochs; ++epoch) errors = *device.train_epoch();
      for (std::size_t i = 0; i < some.size(); ++i) {
        nn::CycleErrors expected;
        const nn::BatchState<double> reference = c.reference<double>(some[i], epochs, &expected);
        const nn::BatchState<double> state = device.state(i);
        const std::string what = std::string(nn::name(rule)) + ", batches of " + std::to_string(batch);
        EXPECT_LT(largest_difference(state.weights.values, reference.weights.values), 1e-12) << what;
        EXPECT_LT(largest_difference(state.first.values, reference.first.values), 1e-12) << what;
        EXPECT_LT(largest_difference(state.second.values, reference.second.values), 1e-12) << what;
        EXPECT_NEAR(errors[i].sse, expected.sse, 1e-12 * expected.sse) << what;
        EXPECT_NEAR(errors[i].largest, expected.largest, 1e-12) << what;
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Topologies, TrainGroupBatch,
                         ::testing::Values("6-5-1", "16-16-8-1", "2-1-1", "6-3-4-1", "6-4-3_leaky-relu", "6-4-5-3"));
// PoCL takes up to a minute to compile one of the paper's for 64 or 128 items.
INSTANTIATE_TEST_SUITE_P(Nightly, TrainGroupBatch, ::testing::Values("1", "2", "3", "4", "5", "6"));

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
void expect_bits_of_the_network_alone(Executor& on) {
  for (const int batch : {50, 200}) {
    const BatchOptions options{.batch = batch, .rate = 0.01, .cosine = true, .planned_rows = 4 * 437, .average = 0.9};
    const auto c = make_case<float>("16-16-8-1", 437, options, on);
    Executor single(on.device(), {.threads = 1});
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

TEST(TrainBatchBits, DependOnTheNetworkAlone) { expect_bits_of_the_network_alone(executor()); }
TEST(TrainBatchBits, DependOnTheNetworkAloneOnAGpu) { expect_bits_of_the_network_alone(gpu()); }

// Many networks whose slices share launches, the last of which is not full: each as alone.
TEST(TrainBatchBits, OfManyLargeBatchesOnAGpuDependOnTheNetworkAlone) {
  const auto c = make_case<float>("2-1-1", 700, {.batch = 650}, gpu());
  std::vector<OnlineMember> many;
  for (std::uint32_t i = 0; i < 100; ++i) many.push_back({i, i % 2});
  TrainBatch<float> together = c.device(many);
  const std::vector<nn::CycleErrors> errors = *together.train_epoch();
  for (const std::size_t i : {0u, 84u, 85u, 99u}) {
    TrainBatch<float> alone = c.device({many[i]});
    EXPECT_EQ(errors[i].sse, alone.train_epoch()->front().sse) << i;
    EXPECT_EQ(together.state(i).weights.values, alone.state(0).weights.values) << i;
  }
}

// Two devices: PoCL's other driver has a runtime of its own.
TEST(TrainBatchBits, AreThoseOfAnotherDevice) {
  Executor other(device("pthread").as_gpu(), {.threads = 1});
  std::vector<std::vector<float>> found;
  for (Executor* on : {&gpu(), &other}) {
    const auto c = make_case<float>("16-16-8-1", 100, {.batch = 30}, *on);
    TrainBatch<float> device = c.device({{7, 0}, {8, 1}});
    for (int epoch = 0; epoch < 3; ++epoch) device.train_epoch();
    found.push_back(device.state(1).weights.values);
  }
  EXPECT_EQ(found[0], found[1]);
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
